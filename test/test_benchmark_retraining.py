"""The retraining suite: choices, resuming and figures, from small runs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import retraining
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.effect_cases import EffectCase, SINGLE
from hand_load_estimator.benchmark.effect_measure import Prepared
from hand_load_estimator.benchmark.effect_recordings import NewArm, Recordings
from hand_load_estimator.benchmark.measure import MOMENTS
from hand_load_estimator.benchmark.other_pages import retraining_blocks
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.learning.artefact import CARD, WEIGHTS
from hand_load_estimator.learning.training import Recipe
from hand_load_estimator.torque.model_file import read_model

PLANT = seeds.DEVELOPMENT_PLANTS[45]


def copied(folder, factor):
    """Write the shipped artefact with intervals `factor` times as wide."""
    source = find_shared('ur10e', 'learned')
    tensors = load_file(source / WEIGHTS)
    tensors['calibration'] *= np.float32(factor)
    folder.mkdir()
    save_file(tensors, folder / WEIGHTS)
    (folder / CARD).write_bytes((source / CARD).read_bytes())


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """Return a result of a case whose training and diagnosis are made up, and what was trained."""
    old, trained = read_model(find_shared('ur10e', 'models')), []
    better = replace(old, mean=1.001 * old.mean)
    finding = SimpleNamespace(name='torque_ripple', joints=('elbow_joint',), changed=False,
                              verdict='confirmed', recording='')
    unsure = SimpleNamespace(**{**vars(finding), 'verdict': 'suspected'})
    monkeypatch.setattr(retraining, 'prepared', lambda *_: Prepared(
        NewArm(old, None, {}), Recordings((), (), ()), ()))
    monkeypatch.setattr(retraining, 'diagnosis_of', lambda *_: (
        SimpleNamespace(findings=(finding, unsure)), better, 1.0))

    def train(model_path, folder, recipe, start_from):
        assert read_model(model_path).mean == pytest.approx(better.mean)
        trained.append((folder.name, start_from))
        copied(folder, 2.0 if start_from else 3.0)

    monkeypatch.setattr(retraining, 'train', train)
    recipes = {'fine-tuned': Recipe(passes=1), 'trained anew': retraining.FROM_SCRATCH}
    case = EffectCase(SINGLE, PLANT, retraining.HIDDEN[:1])
    arguments = find_shared('ur10e', 'robots'), case, None, tmp_path, 1, recipes
    found = retraining.measure_retraining(*arguments)
    monkeypatch.setattr(retraining, '_judged', lambda *_: ([], {}))
    retraining.measure_retraining(*arguments)
    return found, trained


def test_every_choice_is_judged_by_its_own_model_and_artefact_made_once(measured):
    found, trained = measured
    assert [name for name, _ in trained] == ['fine-tuned', 'trained anew']
    assert trained[0][1] is not None and trained[1][1] is None
    assert found['found'] == 'torque_ripple on elbow_joint'
    rows = {choice: np.array(row) for choice, row in found['rows'].items()}
    assert {row.shape for row in rows.values()} == {(len(found['loads']), len(MOMENTS), 2, 10)}
    kept = rows[retraining.KEPT]
    for choice, factor in (('fine-tuned', 2.0), ('trained anew', 3.0)):
        np.testing.assert_array_equal(rows[choice][:, :, 0, :4], kept[:, :, 0, :4])
        ratio = rows[choice][:, :, 1] / kept[:, :, 1]
        assert np.median(ratio) == pytest.approx(factor, rel=0.02)
    for other in (retraining.OLD, retraining.WITHOUT):
        assert (rows[other][:, :, 0] != kept[:, :, 0]).any()


def test_figures_are_of_errors_and_intervals():
    loads = np.tile([3.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1], (4, 1))
    rows = np.zeros((4, len(MOMENTS), 2, 10))
    rows[:, :, 0], rows[:, :, 1] = loads[:, None], 0.01
    rows[:, :, 0, 0] += 0.03
    rows[:, :, 0, 1] += 0.004
    found = {'a': {'effect': 'torque_ripple', 'plant': 1, 'joints': ['elbow'],
                   'found': 'nothing', 'seconds': {'new': 90.0}, 'loads': loads.tolist(),
                   'rows': {'new': rows.tolist()}}}
    scores = retraining.retraining_scores(found)
    figures = scores['cases'][0]['choices']['new']
    assert figures['mass']['1 s'] == pytest.approx(0.03)
    assert figures['com']['end'] == pytest.approx(0.004)
    assert figures['half_width']['1 s'] == pytest.approx(0.0196, abs=1e-4)
    assert figures['coverage'] == pytest.approx(0.9)
    page = to_markdown(retraining_blocks(scores))
    assert '| new | 1.5 | 30.0 | 30.0 |' in page and '| 4.00 | 20 | 90.0 |' in page
