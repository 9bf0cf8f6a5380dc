"""Suggested motions and pushes: figures from rows made by hand, and one small run of each."""

import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import pushes, suggestion
from hand_load_estimator.benchmark.contestants import OUR_MODEL
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.estimators.build import shipped_difference
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.simulation.simulate_motions import named_motion
from hand_load_estimator.torque.model_file import read_model


@pytest.fixture
def shipped(monkeypatch):
    """Let every suite look through the shipped model; return it."""
    model = read_model(find_shared('ur10e', 'models'))
    for module in (pushes, suggestion):
        monkeypatch.setattr(module, 'robot_and_models', lambda path, plant, functions: (
            model.robot, {'ours': model, 'difference': dict.fromkeys(
                functions, shipped_difference(model))}))
    return model


# Suggested motions.

def rows(*errors):
    """Return rows 0.1 s apart of (mass error [kg], place error [m]), a joint ever farther away."""
    return [(0.1 * k, mass, place, 0.2 * k) for k, (mass, place) in enumerate(errors)]


def test_settled_is_when_mass_and_place_are_right_for_good():
    right, light, off = (0.01, 0.001), (0.2, 0.001), (0.01, 0.004)
    assert suggestion.settled(rows(off, right, right), 0.1) == {
        'settled': pytest.approx(0.1), 'away': pytest.approx(0.2)}
    # Right for a moment only is not settled.
    assert suggestion.settled(rows(light, right, off, right), 0.1)['settled'] \
        == pytest.approx(0.3)
    assert suggestion.settled(rows(right, off, light), 0.1) == {
        'settled': None, 'away': pytest.approx(0.4)}
    assert suggestion.settled(rows(right, right), 0.1) == {'settled': 0.0, 'away': 0.0}


def test_an_ordinary_move_begins_when_it_is_told(shipped):
    motion = named_motion('pick_place', shipped.robot, 4.0, 1.0, 3)
    told = suggestion._without_hold(motion)
    assert told.start == 0.0
    np.testing.assert_array_equal(told.position[0], motion.position[0])
    assert np.abs(told.sample(0.1)[1]).max() > 0.05 > np.abs(motion.sample(0.1)[1]).max()


def test_suggested_motions_and_an_ordinary_move_are_of_the_same_load(shipped, monkeypatch):
    monkeypatch.setattr(suggestion, 'LENGTH', 4.0)
    found = suggestion.measure_suggestion('ur10e', seeds.SHIPPED_MODEL_PLANT,
                                          seeds.DEVELOPMENT_CASES[997], 'bayes', None)
    assert found['mass'] >= suggestion.LEAST_MASS
    assert found['suggested']['motions'] >= 1 == found['ordinary']['motions']
    for name in ('suggested', 'ordinary'):
        assert found[name]['settled'] is None or 0.0 < found[name]['settled'] < 4.0
        assert found[name]['away'] > 0.01
    page = to_markdown(suggestion.suggestion_blocks(
        suggestion.suggestion_scores({'suggestion_a': found}, 'bayes')))
    assert '`bayes` on an arm that has stood for 1.5 s' in page


def test_medians_count_what_never_settled():
    def run(suggested, ordinary):
        return {'plant': 1, 'mass': 3.0, **{
            name: {'settled': time, 'away': 0.1, 'motions': 1}
            for name, time in (('suggested', suggested), ('ordinary', ordinary))}}
    found = suggestion.suggestion_scores(
        {'a': run(0.5, 1.0), 'b': run(None, 2.0), 'c': run(0.7, None)}, 'lstm')
    assert found['sooner'] == 2
    assert found['suggested'] == {'median': 0.7, 'settled': 2, 'away': pytest.approx(0.1)}
    assert found['ordinary']['median'] == 2.0
    page = to_markdown(suggestion.suggestion_blocks(found))
    assert '| suggested motions | 0.70 | 2 of 3 | 0.10 |' in page
    assert '| 1 | 3.0 | - | 2.00 | 1 |' in page


# Pushes.

def test_a_push_is_of_its_force_and_any_direction(shipped):
    starts, ways = [], []
    for seed in seeds.DEVELOPMENT_CASES[:20]:
        case, start = pushes.draw_push(shipped.robot, seeds.DEVELOPMENT_PLANTS[94], seed, 60.0)
        (entry,) = case.hidden
        assert entry['parameters']['force'] == 60.0 and entry['parameters']['start'] == start
        starts.append(start)
        ways.append(entry['parameters']['direction'])
    assert pushes.START[0] <= min(starts) < max(starts) <= pushes.START[1]
    np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1.0)
    assert (np.ptp(ways, axis=0) > 1.0).all()


def test_errors_are_of_before_during_and_after_the_push():
    stamps = np.arange(0.0, 8.0, 0.5)
    error = np.select([stamps < 5.0, stamps < 6.0, stamps < 7.0], [0.1, 2.0, 9.0], 0.3)
    figures = pushes.push_figures(stamps, error, stamps == 5.5, 5.0)
    assert figures == {'before': pytest.approx(0.1), 'during': pytest.approx(2.0),
                       'after': pytest.approx(0.3), 'told': 0.5}
    found = pushes.push_scores({
        force: {'plant': 1, 'force': force, 'mass': 2.0, 'from_vertical': force,
                'methods': {'bayes': {**figures, **more}}}
        for force, more in ((60.0, {'changes': 0}), (30.0, {'during': 0.0, 'changes': 2}))})
    of = found['methods']['bayes']
    assert (of['worst'], of['changed'], of['told']) == (2.0, 1, 0.5)
    assert of['during'] == pytest.approx(np.sqrt(2.0))
    page = to_markdown(pushes.push_blocks(found))
    assert '| bayes | 100 | 1414 | 2000 | 300 | 50 | 1 of 2 |' in page
    assert '| 30 | 1 | 2.0 | 30 | 0, 300 |\n| 60 | 1 | 2.0 | 60 | 2000, 300 |' in page


def test_up_and_down_are_vertical_and_sideways_is_not():
    slanted = np.array([0.6, 0.0, -0.8])
    angles = [pushes.from_vertical(way) for way in (np.eye(3)[2], -np.eye(3)[2], slanted,
                                                    np.eye(3)[0])]
    np.testing.assert_allclose(angles, [0.0, 0.0, 36.87, 90.0], atol=0.01)


def test_a_push_moves_who_keeps_nothing_out(shipped):
    found = pushes.measure_push('ur10e', seeds.SHIPPED_MODEL_PLANT, seeds.DEVELOPMENT_CASES[998],
                                60.0, None, ('bayes', 'gp_bayes'))
    assert set(found['methods']) == {'bayes', 'gp_bayes', OUR_MODEL}
    gated, open_ = found['methods']['bayes'], found['methods'][OUR_MODEL]
    assert gated['told'] > 0.5 and open_['told'] == 0.0
    assert gated['during'] < 0.5 * open_['during'] and abs(gated['after']) < abs(open_['after'])


def test_jobs_are_on_their_own_seeds():
    jobs = [*suggestion.suggestion_jobs('r.yaml', 12, 'bayes', None, development=True).values(),
            *pushes.push_jobs('r.yaml', 8, None, None, development=True).values()]
    assert all(job[1] in seeds.DEVELOPMENT_PLANTS for job in jobs)
    assert all(job[2] in seeds.DEVELOPMENT_CASES for job in jobs)
    assert len({job[2] for job in jobs}) == 20 and len({job[1] for job in jobs}) == 3
    assert [job[3] for job in jobs[12:]] == [30.0, 60.0] * 4
    own = suggestion.suggestion_jobs('r.yaml', 1, 'bayes', None)
    assert all(job[1] in seeds.BENCHMARK_PLANTS for job in own.values())
