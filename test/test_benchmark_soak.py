"""The soak suite: a closed loop replayed for hours, killed and resumed; growth and drift told."""

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator.benchmark import soak
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.benchmark.other_pages import soak_blocks
from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.estimators.method import Belief
from hand_load_estimator.plant import JointEvent, TemperatureEvent


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
