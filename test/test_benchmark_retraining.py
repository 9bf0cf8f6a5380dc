"""The retraining suite: choices, resuming and figures, from small runs."""

from types import SimpleNamespace

import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import retraining
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.measure import MOMENTS
from hand_load_estimator.benchmark.other_pages import retraining_blocks
from hand_load_estimator.learning.training import Recipe
from hand_load_estimator.model_file import read_model
from hand_load_estimator.shared_files import find_shared

PLANT = seeds.DEVELOPMENT_PLANTS[45]


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """Return a result with the shipped model as old and better one, and what was trained."""
    model, trained = read_model(find_shared('ur10e', 'models')), []
    monkeypatch.setattr(retraining, 'prepared', lambda *_: (
        SimpleNamespace(model=model), SimpleNamespace(evidence=(), test=())))
    monkeypatch.setattr(retraining, 'diagnosis_of', lambda *_: (None, model, 1.0))

    def train(model_path, folder, recipe, start_from):
        trained.append((folder.name, start_from))
        folder.mkdir()
        source = find_shared('ur10e', 'learned')
        for name in ('lstm.safetensors', 'card.json'):
            (folder / name).write_bytes((source / name).read_bytes())

    monkeypatch.setattr(retraining, 'train', train)
    recipes = {'fine-tuned': Recipe(passes=1), 'trained anew': retraining.FROM_SCRATCH}
    arguments = (find_shared('ur10e', 'robots'), PLANT, *retraining.HIDDEN[0], None, tmp_path, 1,
                 recipes)
    found = retraining.measure_retraining(*arguments)
    retraining.measure_retraining(*arguments)
    return found, trained


def test_artefacts_are_made_once_and_only_one_from_scratch(measured):
    found, trained = measured
    assert [name for name, _ in trained] == ['fine-tuned', 'trained anew']
    assert trained[0][1] is not None and trained[1][1] is None
    shape = (len(found['loads']), len(MOMENTS), 2, 10)
    assert {np.shape(rows) for rows in found['rows'].values()} == {shape}
    # The same model and weights give the same answer under any name, another method another.
    rows = found['rows']
    assert rows['fine-tuned'] == rows[retraining.KEPT] == rows['trained anew']
    assert rows['none (`bayes`)'] != rows[retraining.KEPT]


def test_figures_are_of_errors_and_intervals():
    loads = np.tile([3.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1], (4, 1))
    rows = np.zeros((4, len(MOMENTS), 2, 10))
    rows[:, :, 0], rows[:, :, 1] = loads[:, None], 0.01
    rows[:, :, 0, 0] += 0.03
    rows[:, :, 0, 1] += 0.004
    found = {'a': {'effect': 'torque_ripple', 'plant': 1, 'joints': ['elbow'],
                   'seconds': {'new': 90.0}, 'loads': loads.tolist(),
                   'rows': {'new': rows.tolist()}}}
    scores = retraining.retraining_scores(found)
    figures = scores['cases'][0]['choices']['new']
    assert figures['mass']['1 s'] == pytest.approx(0.03)
    assert figures['com']['end'] == pytest.approx(0.004)
    assert figures['half_width']['1 s'] == pytest.approx(0.0196, abs=1e-4)
    assert figures['coverage'] == pytest.approx(0.9)
    page = to_markdown(retraining_blocks(scores))
    assert '| new | 1.5 | 30.0 | 30.0 |' in page and '| 4.00 | 20 | 90.0 |' in page
