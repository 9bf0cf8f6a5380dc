"""Changes, measured recordings, cost and soak: from small runs and from results made by hand."""

import math
import os
from pathlib import Path
import subprocess
import sys

from core_helpers import block, four_axes
import numpy as np
import pytest
from ros_helpers import ROOT

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases, change_scores, changes, cost, real, soak
from hand_load_estimator.benchmark.contestants import (chosen_methods, Contestant, cost_of,
                                                       functions_of, NOMINAL, OUR_MODEL,
                                                       REGRESSOR, TEXTBOOK, TEXTBOOK_CAREFUL)
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.other_pages import (change_blocks, cost_blocks, real_blocks,
                                                       soak_blocks)
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.learning.difference_artefact import PREDICTORS
from hand_load_estimator.model_file import read_model
from hand_load_estimator.plant import JointEvent, TemperatureEvent
from hand_load_estimator.shared_files import find_shared
from hand_load_estimator.simulate_motions import named_motion

DATA = Path(os.environ.get('HAND_LOAD_DATA', ROOT.parent / 'shared' / 'data'))


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
    return {'kind': kind, 'plant': 1, 'at': at, 'moved': moved, 'seen': {'bayes': list(stamps)},
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
    assert figures['kinds']['drop'] == {'changes': 1, 'missed': 1,
                                        'delay_median': pytest.approx(math.nan, nan_ok=True)}
    assert (figures['false_alarms'], figures['hours']) == (2, 2.0)
    page = to_markdown(change_blocks({'methods': {'bayes': figures}}))
    assert '| bayes | 4 | 1 | 0 | 1 | 0 | 0.10 |' in page and 'Not measured here' not in page
    # Errors 30 and 90 g after half an hour, std 20 g.
    assert '| bayes | 2 | 2.0 | 50.00 | 67 | 50 |' in page
    page = to_markdown(change_blocks({'methods': {'bayes': figures}, 'left_out': ['gp_bayes']}))
    assert 'Not measured here: `gp_bayes`;' in page


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


def test_a_pick_is_seen_and_running_raises_no_alarm(monkeypatch):
    """The shipped model on the arm it was identified from."""
    model = read_model(find_shared('ur10e', 'models'))
    monkeypatch.setattr(changes, 'robot_and_model', lambda *_: (model.robot, model))
    monkeypatch.setattr(changes, 'DURATION', 6.0)
    monkeypatch.setattr(changes, 'CHANGE_AT', (2.0, 2.5))
    plant = seeds.SHIPPED_MODEL_PLANT
    found = changes.measure_job('change', 'ur10e', plant, seeds.DEVELOPMENT_CASES[700], 'pick',
                                None, ('bayes',))
    assert found['at'] <= found['moved'] < 6.0
    (stamps,) = found['seen'].values()
    assert stamps and found['at'] <= stamps[0] < found['moved'] + 2.0
    assert change_scores.found_load('bayes', found)
    quiet = changes.measure_job('running', 'ur10e', plant, seeds.DEVELOPMENT_CASES[701], 4.0,
                                None, ('bayes',))
    assert quiet['changes'] == {'bayes': 0} and quiet['samples'] > 150
    error, std = quiet['end']['bayes']
    assert abs(error) < 4.0 * std < 4.0


# Measured recordings.

def test_the_error_on_a_recording_is_less_what_the_model_was_identified_with():
    runs = {'real_a': [{'set': 'a', 'run': 'r', 'truth': 150.0, 'rated': 300.0,
                        'methods': {'bayes': [None, None, None, None, [153.0, 2.0]]}},
                       {'set': 'a', 'run': 's', 'truth': 0.0, 'rated': 10.0,
                        'methods': {'bayes': [None, None, None, None, [0.3, 0.1]]}}]}
    content = real.real_scores(runs)
    assert content['methods']['bayes'] == {'runs': 2, 'median_percent': pytest.approx(2.0),
                                           'worst_percent': pytest.approx(3.0), 'inside': 0.5}
    assert '+3.000 (2.000)' in to_markdown(real_blocks(content))


def test_where_nothing_is_held_ours_are_judged_as_rivals_are():
    """What is published never weighs less than nothing: half of noise would be gone."""
    class Noisy:
        tared = np.zeros(10)

        def belief(self):
            return Belief(np.r_[-0.01, np.zeros(9)], 1e-4 * np.eye(10))

        def update(self, sample, prediction):
            return self.belief()

    racing = {'bayes': Contestant(None, lambda _: Noisy())}
    beliefs = {name: contestant.update(None) for name, contestant in racing.items()}
    assert beliefs['bayes'].mean[0] >= 0.0
    assert real.judged(racing, beliefs, 0.0)['bayes'].mean[0] == -0.01
    assert real.judged(racing, beliefs, 2.6) is beliefs


def test_data_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match='--data'):
        real.real_jobs(tmp_path / 'none', None, tmp_path, None)
    (tmp_path / 'panda').mkdir()
    assert list(real.real_jobs(tmp_path, None, tmp_path, None)) == ['real_panda']


@pytest.mark.skipif(not (DATA / 'staubli_tx40').is_dir(), reason=f'no recordings at {DATA}')
def test_a_measured_set_is_identified_and_estimated(tmp_path):
    (found,) = real.measure_set('staubli_tx40', str(DATA), str(tmp_path), ('bayes',))
    assert set(found['methods']) == {'bayes', NOMINAL, TEXTBOOK, TEXTBOOK_CAREFUL, OUR_MODEL}
    assert found['truth'] == 0.0 and found['rated'] == 1.7
    mass, std = found['methods']['bayes'][-1]
    assert abs(mass) < 1.7 and 0.0 < std < 1.0
    # The nominal model knows no friction: its rival is not given the identified one by mistake.
    assert found['methods'][NOMINAL][-1] != found['methods'][TEXTBOOK][-1]


# Cost and memory.

def test_the_first_sample_is_no_running_cost():
    assert cost_of([9.0, *[1.0] * 98, 3.0]) == {
        'mean': pytest.approx(101.0 / 99.0), 'p50': 1.0, 'p99': pytest.approx(1.04, abs=0.01)}


def test_cost_is_told_over_one_regressor_call():
    found = {'name': 'bayes', 'cost': {'mean': 3e-4, 'p50': 2e-4, 'p99': 9e-4},
             'regressor': {'mean': 1e-5, 'p50': 1e-5, 'p99': 2e-5},
             'joint_state': {'mean': 5e-5, 'p50': 4e-5, 'p99': 8e-5}, 'start_mib': 1.0,
             'growth_mib': 0.25}
    content = cost.cost_scores({'cost_lstm': found})
    assert content['cost'][REGRESSOR]['mean'] == 1e-5
    page = to_markdown(cost_blocks(content))
    # 500 joint states of 50 us and 50 samples of 300 us are 40 ms of every second.
    assert '| lstm | 300.0 | 200.0 | 900.0 | 30 | 90 | 4.0 | +1.0 | +0.2 |' in page
    assert 'guard and filter | 50.0 | 40.0 | 80.0 | 5 | 8 | - | - | - |' in page
    assert 'joint torque regressor call (whole arm)' in page
    assert '`lstm` has no artefact here and ran as `bayes`' in page


def test_every_joint_state_is_timed_and_samples_are_as_before():
    robot = four_axes()
    events = list(cases.motion_events(robot, named_motion('pick_place', robot, 1.0, 0.5, 1)))
    stream = cost.TimedStream(robot)
    samples = list(cases.stream_samples(robot, events, stream))
    assert len(stream.times) == sum(isinstance(event, JointEvent) for event in events) > 100
    assert min(stream.times) > 0.0
    plain = list(cases.stream_samples(robot, events))
    assert len(plain) == len(samples)
    np.testing.assert_array_equal([s.effort for s in plain], [s.effort for s in samples])


def test_a_method_on_a_learned_difference_has_its_cost(monkeypatch):
    """On the difference shipped for the model; 50 samples are warm-up."""
    monkeypatch.setattr(cases, 'DURATION', 2.0)
    found = cost.measure_cost('ur10e', 'gp_bayes', None)
    assert found['name'] == 'gp_bayes'
    assert found['cost']['mean'] > found['regressor']['mean'] > 0.0
    assert found['joint_state']['mean'] > 0.0


def test_e2_6_every_function_of_the_difference_can_be_chosen_and_is_learned():
    assert functions_of(('bayes', 'lstm')) == ()
    assert functions_of(('gp_bayes', 'gp_swarm')) == ('gp',)
    assert functions_of(('gp_bayes_distilled',)) == ('distilled',)
    assert functions_of() == tuple(sorted(PREDICTORS))
    with pytest.raises(ConfigurationError, match='--methods.*gp_bayes_neural_process'):
        chosen_methods(('gp_bayes_magic',))


def test_every_method_has_a_cost_job():
    """But for functions of the torque difference of which none is shipped."""
    assert set(cost.cost_jobs('ur10e', None, None)) \
        == {f'cost_{name}' for name in chosen_methods()} \
        - {'cost_gp_bayes_neural_process', 'cost_gp_bayes_distilled',
           'cost_gp_bayes_bayesian_network'}


def test_resident_memory_is_seen():
    """In a process of its own: here freed memory of other tests may serve again."""
    grown = subprocess.run([sys.executable, '-c', (
        'import numpy as np\n'
        'from hand_load_estimator.benchmark.memory import resident_mib\n'
        'before = resident_mib()\n'
        'held = np.ones(4_000_000)\n'
        'print(resident_mib() - before)')], cwd=ROOT, capture_output=True, text=True, check=True)
    assert 20.0 < float(grown.stdout) < 60.0


# Soak.

class Counting:
    """A pipeline that only counts; its state is what it has counted."""

    def __init__(self, robot, change_at=None):
        self.model = type('Model', (), {'robot': robot})
        self.samples, self.rejected, self.stamps, self.restored = 0, {}, [], ''
        self._mean = np.r_[robot.rated_load.mass, np.zeros(9)]
        self.method, self.changes, self.read, self._change_at = self, 0, 0, change_at

    def belief(self):
        return Belief(self._mean, np.eye(10))

    @property
    def load_id(self):
        return self.changes

    def temperature_reading(self, joint, celsius):
        self.read += 1

    def joint_state(self, stamp, names, position, velocity, effort):
        self.samples += 1
        self.stamps.append(stamp)
        self.changes += stamp == self._change_at

    def settle(self):
        pass

    def state(self):
        return {'changes': np.array(self.changes), 'none yet': np.zeros((0, 4, 10))}

    def restore(self, state, told):
        assert state['none yet'].shape == (0, 4, 10)
        self.changes, self.restored = int(state['changes']), told


def second_of(robot):
    """Return the events of a second at 100 Hz."""
    zero = np.zeros(robot.n)
    return [TemperatureEvent(0.0, zero + 25.0),
            *(JointEvent(0.01 * k, zero, zero, zero) for k in range(100))]


def test_where_the_loop_is_closed_nothing_jumps(monkeypatch):
    """A torque that jumps at rest is another load's; the real estimator sees none."""
    monkeypatch.setattr(soak, 'LOOP', 12.0)
    pipeline = build_pipeline('ur10e', 'bayes')
    events, length = soak.looped_events(pipeline.model.robot)
    found = soak.replay(pipeline, events, length, 2.5 * length / 3600.0)
    assert len(found['rows']) == 3 and found['load_changes'] == 0 and not found['rejected']
    assert abs(found['mass'] - found['true_mass']) < 0.05


def test_loops_are_replayed_without_a_gap_in_time():
    robot = four_axes()
    pipeline, kept = Counting(robot), []
    found = soak.replay(pipeline, second_of(robot), 1.0, 5.0 / 3600.0, keep=kept.append)
    assert pipeline.samples == found['samples'] == 500 and pipeline.read == 20
    np.testing.assert_allclose(np.diff(pipeline.stamps), 0.01, atol=1e-9)
    assert found['hours'] == pytest.approx(5.0 / 3600.0) and len(found['rows']) == 5
    assert [len(part['rows']) for part in kept] == [1, 2, 3, 4, 5] and kept[-1] == found
    assert all(0.0 < mean <= tail and unit > 0.0 for _, _, mean, tail, unit, _ in found['rows'])
    page = to_markdown(soak_blocks({**soak.soak_scores(found), 'method': 'bayes'}))
    assert '(none happened)' in page and 'gone on with' not in page


def test_a_soak_that_was_killed_goes_on_where_it_was(tmp_path, monkeypatch):
    """Counts and state go on in another process; what follows the last row is replayed again."""
    robot, made = four_axes(), []

    def build(*_):
        made.append(Counting(robot, change_at=soak.EPOCH + 1.5))
        return made[-1]

    monkeypatch.setattr(Counting, 'name', 'counting', raising=False)
    monkeypatch.setattr(soak, 'build_pipeline', build)
    monkeypatch.setattr(soak, 'looped_events', lambda _: (second_of(robot), 1.0))
    told, hours = [], 6.0 / 3600.0

    def killed(text):
        told.append(text)
        if len(told) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        soak.run_soak('four', 'bayes', None, hours, tmp_path, killed)
    found = soak.run_soak('four', 'bayes', None, hours, tmp_path, told.append)
    first, second = made
    assert first.stamps[-1] == pytest.approx(soak.EPOCH + 2.99)
    assert second.stamps[0] == pytest.approx(soak.EPOCH + 3.0) and second.restored
    assert found['samples'] == 600 and found['load_changes'] == 1 == second.load_id
    assert [row[-1] for row in found['rows']] == [0, 0, 0, 1, 1, 1] and found['processes'] == 2
    assert '2 processes' in to_markdown(soak_blocks(found)) and 'state' not in found
    # What is done is only read.
    assert soak.run_soak('four', 'bayes', None, hours, tmp_path, None) == found
    assert len(made) == 2


@pytest.mark.parametrize(('memory', 'mean', 'tail', 'flat'), [
    (0.0, 0.0, 0.0, (True, True)), (1.0, 0.0, 0.0, (False, True)),
    (0.0, 0.01, 0.0, (True, False)), (0.0, 0.0, 0.01, (True, False))])
def test_growth_and_drift_are_seen(memory, mean, tail, flat):
    rows = [[0.24 * k, 300.0 + memory * k, 1e-3 * (1.0 + mean * k), 2e-3 * (1.0 + tail * k),
             1e-5, 0] for k in range(100)]
    found = soak.soak_scores({'rows': rows, 'hours': 24.0, 'seconds': 3600.0})
    assert (found['flat_memory'], found['flat_time']) == flat
    assert found['times_real_time'] == pytest.approx(24.0)


def test_a_slower_machine_is_no_drift_of_ours():
    """Everything takes twice as long in the second half."""
    rows = [[0.24 * k, 300.0, *(np.array([1e-3, 2e-3, 1e-5]) * (1 + (k > 50))), 0]
            for k in range(100)]
    found = soak.soak_scores({'rows': rows, 'hours': 24.0, 'seconds': 3600.0})
    assert found['flat_time'] and found['time_drift_percent'] == pytest.approx(0.0)


def test_memory_is_compared_within_a_process():
    """Another process begins with less; what each of them gained counts."""
    rows = [[0.24 * k, 300.0 + 0.1 * (k % 50) + 100.0 * (k < 50), 1e-3, 2e-3, 1e-5, k // 50]
            for k in range(100)]
    found = soak.soak_scores({'rows': rows, 'hours': 24.0, 'seconds': 3600.0})
    assert found['growth_mib'] == pytest.approx(2 * 4.5) and found['processes'] == 2
