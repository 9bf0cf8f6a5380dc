"""The changes suite: draws, delays, false alarms and loads found, by hand and from small runs."""

import math

from core_helpers import block, four_axes
import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import change_scores, changes
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.other_pages import change_blocks
from hand_load_estimator.estimators.build import shipped_difference
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.torque.model_file import read_model


@pytest.mark.parametrize('kind', changes.KINDS)
def test_a_change_is_of_its_kind(kind):
    robot = four_axes()
    scale = robot.rated_load.mass / 12.5
    for seed in seeds.DEVELOPMENT_CASES[:30]:
        before, after, at = changes.draw_change(robot, seed, kind)
        assert changes.CHANGE_AT[0] <= at <= changes.CHANGE_AT[1]
        assert (before.mass == 0.0) == (kind == 'pick') and (after.mass == 0.0) == (kind == 'drop')
        if kind == 'slip':
            moved = before.mass * np.linalg.norm(after.com - before.com)
            assert after.mass == before.mass and 0.1 * scale <= moved <= 0.3 * scale


def seen(kind, at, moved, *stamps, off=0.0, place=0.0):
    """Return a run at whose end mass [kg] and place [m] are off; stds are 0.1 kg and 1 mm."""
    load = block(5.0).to_message()
    mean = load + np.r_[off, place, np.zeros(8)]
    return {'kind': kind, 'plant': 1, 'at': at, 'moved': moved,
            'earliest': None if moved is None else moved + 0.05, 'seen': {'bayes': list(stamps)},
            'load': load.tolist(), 'rated': 12.5,
            'end': {'bayes': [mean.tolist(), [0.1, *[1e-3] * 9]]}}


def ran(seconds, count):
    return {'plant': 1, 'seconds': seconds, 'samples': 10, 'changes': {'bayes': count},
            'mismatch': {'bayes': 0.5}, 'end': {'bayes': [0.03 * (1 + count), 0.02]}}


def test_delays_count_from_motion_and_only_after_the_change():
    results = {'change_a': seen('pick', 5.0, 6.0, 6.1),
               'change_b': seen('pick', 5.0, 6.0, 4.0, 6.3),
               'change_c': seen('drop', 5.0, 6.0), 'change_d': seen('slip', 5.0, 6.0, 5.5),
               'change_e': seen('slip', 5.0, None),
               'running_a': ran(1800.0, 0), 'running_b': ran(5400.0, 2)}
    figures = change_scores.change_scores(results)['methods']['bayes']
    assert (figures['changes'], figures['missed'], figures['too_early']) == (4, 1, 1)
    # Seen at rest before the first motion is seen at once.
    assert figures['delays'] == pytest.approx([0.1, 0.3, 0.0])
    assert figures['delay_median'] == pytest.approx(0.1)
    never = pytest.approx(math.nan, nan_ok=True)
    assert figures['kinds']['drop'] == {'changes': 1, 'missed': 1, 'delay_median': never,
                                        'delay_longest': never}
    assert figures['kinds']['pick']['delay_longest'] == pytest.approx(0.3)
    assert (figures['false_alarms'], figures['hours']) == (2, 2.0)
    scores = change_scores.change_scores(results)
    page = to_markdown(change_blocks(scores))
    assert 'after 0.05 s by median, after 0.05 s at the 95th percentile' in page
    assert '| 0.20 to 0.30 s, 0 of 2 missed |' in page
    assert '| bayes | 4 | 1 | 0 | 1 | 0 | 0.10 |' in page
    # Errors 30 and 90 g after half an hour, std 20 g.
    assert '| bayes | 2 | 2.0 | 50.00 | 67 | 50 |' in page


def test_a_change_counts_as_seen_only_where_its_load_is_found():
    """A change that is taken back to the old load is none that was seen."""
    results = {'change_a': seen('pick', 5.0, 6.0, 6.1, 7.2, off=5.0),
               'change_b': seen('slip', 5.0, 6.0, 6.1, place=0.02),
               'change_c': seen('pick', 5.0, 6.0, 6.2, 6.4, 6.9, off=0.24, place=0.0029),
               'change_d': seen('exchange', 5.0, 6.0, off=5.0)}
    figures = change_scores.change_scores(results)['methods']['bayes']
    assert (figures['missed'], figures['wrong'], figures['extra']) == (3, 2, 3)
    assert figures['delays'] == pytest.approx([0.2])
    # Where nothing is held there is no place to be wrong about.
    empty = {**seen('drop', 5.0, 6.0, 6.1, place=0.3), 'load': [0.0] * 10}
    empty['end'] = {'bayes': [[0.1, 0.3, *[0.0] * 8], [0.1, *[1e-3] * 9]]}
    assert change_scores.found_load('bayes', empty)


def test_jobs_of_changes_are_as_many_as_asked_on_their_own_seeds():
    jobs = changes.change_jobs('r.yaml', 6, 1.25, None, None, development=True)
    kinds = [job[4] for job in jobs.values() if job[0] == 'change']
    assert kinds == ['pick', 'exchange', 'drop', 'slip', 'pick', 'exchange']
    assert [job[4] for job in jobs.values() if job[0] == 'running'] == [1800.0, 1800.0, 900.0]
    assert all(job[2] in seeds.DEVELOPMENT_PLANTS for job in jobs.values())
    assert all(job[3] in seeds.DEVELOPMENT_CASES for job in jobs.values())
    assert len({job[3] for job in jobs.values()}) == len(jobs)


def test_more_changes_than_the_suite_has_are_on_arms_of_their_own():
    few, many = ([job for job in changes.change_jobs('r.yaml', count, 0.5, None, None).values()]
                 for count in (changes.CHANGES, 400))
    assert {job[2] for job in few} <= set(seeds.BENCHMARK_PLANTS)
    assert {job[2] for job in many} == set(seeds.FINAL_CHANGE_PLANTS)
    assert {job[3] for job in many} <= set(seeds.FINAL_CHANGE_CASES)


def test_a_pick_is_seen_and_running_raises_no_alarm(monkeypatch):
    """The shipped model on the arm it was identified from."""
    model = read_model(find_shared('ur10e', 'models'))
    monkeypatch.setattr(changes, 'robot_and_models', lambda path, plant, functions: (
        model.robot, {'ours': model, 'difference': dict.fromkeys(
            functions, shipped_difference(model))}))
    monkeypatch.setattr(changes, 'DURATION', 6.0)
    monkeypatch.setattr(changes, 'CHANGE_AT', (2.0, 2.5))
    plant = seeds.SHIPPED_MODEL_PLANT
    found = changes.measure_job('change', 'ur10e', plant, seeds.DEVELOPMENT_CASES[700], 'pick',
                                None, ('bayes', 'gp_bayes'))
    assert found['at'] <= found['moved'] < 6.0
    # A test that knows both loads is no later than one that knows neither.
    assert found['at'] <= found['earliest'] <= min(found['seen']['bayes'])
    assert set(found['seen']) == {'bayes', 'gp_bayes'}
    for name, stamps in found['seen'].items():
        assert stamps and found['at'] <= stamps[0] < found['moved'] + 2.0
        assert change_scores.found_load(name, found)
    quiet = changes.measure_job('running', 'ur10e', plant, seeds.DEVELOPMENT_CASES[701], 4.0,
                                None, ('bayes', 'gp_bayes'))
    assert quiet['changes'] == {'bayes': 0, 'gp_bayes': 0} and quiet['samples'] > 150
    error, std = quiet['end']['bayes']
    assert abs(error) < 4.0 * std < 4.0
