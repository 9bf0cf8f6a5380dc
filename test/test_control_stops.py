"""Stops of the cycle against a fake arm: collisions and what is none, silence, an arm held."""

from types import SimpleNamespace

from control_helpers import covariance_of, FakeArm, FAR_PLACE, HOME, load_vector
import numpy as np
import pytest
from supervisor_helpers import Cell

from hand_load_estimator.control.acceleration_limits import PlanSettings
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.torque.model_file import read_model


def test_a_collision_stops_with_a_braking_trajectory_and_waits_for_the_reset():
    cell = Cell()
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying'
                    and c.supervisor.policy.trusted)
    cell.arm.push = np.array([0.0, 120.0, 60.0, 0.0, 0.0, 0.0])
    assert cell.run(0.2, lambda c: c.supervisor.phase == 'stopped')
    assert cell.supervisor.detector.collided and 'collision' in cell.supervisor.stop_reason
    assert 'shoulder_lift_joint' in cell.supervisor.stop_reason
    cell.run(2.5)
    q, v, _ = cell.arm.state(cell.now)
    assert not v.any() and cell.supervisor.phase == 'stopped'
    assert np.max(np.abs(q - FAR_PLACE)) > 0.05 and not cell.supervisor.moving
    cell.arm.push = np.zeros(6)
    assert 'collision' in cell.supervisor.start(), 'a collision is cleared by reset() alone'
    cell.supervisor.reset()
    assert not cell.supervisor.detector.collided
    taken = cell.arm.taken
    cell.run(2.0)
    assert cell.supervisor.phase == 'waiting' and cell.arm.taken == taken, 'a reset moves nothing'
    assert not cell.supervisor.start()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')


def test_joint_states_that_stop_while_moving_stop_the_arm():
    cell = Cell(plan=PlanSettings(speed_scale=0.2))
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'to_pick' and c.supervisor.moving)
    cell.hearing = False
    assert cell.run(1.0, lambda c: c.supervisor.phase == 'stopped')
    assert 'joint states have stopped' in cell.supervisor.stop_reason


ASIDE = np.array([1.7, 0.0, 0.0, 0.0, 0.0, 0.0])
WIDE = {'home': HOME, 'pick': HOME + ASIDE, 'place': HOME - ASIDE}


def full_speed():
    """Return a Cell whose arm is at its fastest between pick and place."""
    cell = Cell(waypoints=WIDE)
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying'
                    and np.max(np.abs(c.arm.state(c.now)[1])) > 1.8)
    return cell


@pytest.mark.parametrize('silence', [0.06, 0.2, 0.35, 5.0])
def test_joint_states_that_stop_at_full_speed_give_no_jump(silence):
    cell = full_speed()
    sent, begin = len(cell.sent), cell.arm.state(cell.now)[0]
    cell.hearing = False
    cell.run(min(silence, 0.6))
    # Far enough for a check against the last measurement to fail.
    assert silence < 0.2 or np.max(np.abs(cell.arm.state(cell.now)[0] - begin)) > 0.25
    assert (cell.supervisor.phase == 'stopped') == (silence > 0.5)
    if silence > 0.5:
        assert len(cell.sent) == sent + 1
        brake, (q, v, _) = cell.sent[-1]
        assert np.max(np.abs(v)) > 1.8, 'the test is about a fast arm'
        np.testing.assert_allclose(brake.position[0], q, atol=1e-6)
        np.testing.assert_allclose(brake.velocity[0], v, atol=1e-6)
        assert not brake.velocity[-1].any()
    cell.hearing = True
    cell.run(2.0)
    assert cell.supervisor.counts['off_path'] == 0
    if silence > 0.5:
        assert cell.supervisor.phase == 'stopped', 'only a reset goes on'
        cell.supervisor.reset()
        cell.supervisor.start()
        assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')


def test_a_collision_noticed_by_old_joint_states_brakes_from_the_reference():
    cell = full_speed()
    cell.hearing = False
    cell.run(0.2)
    cell.supervisor.detector.collided = True
    cell.supervisor.detector.what = (np.array([1]), np.full(6, 9.0), np.full(6, 5.0))
    cell.run(0.02)
    brake, (q, _, _) = cell.sent[-1]
    assert cell.supervisor.phase == 'stopped'
    np.testing.assert_allclose(brake.position[0], q, atol=1e-6)


def test_joint_states_without_velocities_brake_at_the_references_speed():
    cell = full_speed()
    cell.velocities = False
    cell.run(0.02)
    brake = cell.supervisor.stop()
    np.testing.assert_allclose(brake.velocity[0], cell.arm.state(cell.now)[1], atol=1e-6)
    assert np.max(np.abs(brake.velocity[0])) > 0.5


def test_an_arm_that_is_held_is_not_set_off_by_its_release():
    # A protective stop holds the arm while its joint states go on.
    cell = Cell()
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying')
    cell.run(0.3)
    held, take = cell.arm.state(cell.now)[0], cell.arm.take
    cell.arm._plan, cell.arm._rest = None, held
    cell.arm.take = lambda *_: None
    assert cell.run(10.0, lambda c: c.supervisor.tries == 2 and c.supervisor.phase != 'stopped')
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'stopped')
    assert '3 times in a row' in cell.supervisor.stop_reason
    cell.arm.take, sent = take, len(cell.sent)
    cell.run(20.0)
    assert len(cell.sent) == sent and cell.supervisor.phase == 'stopped'
    cell.supervisor.reset()
    cell.supervisor.start()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')


def test_an_arm_held_after_the_grip_has_not_shown_what_it_holds():
    """A protective stop: a motion is sent, nothing moves, and the estimate is of before."""
    cell = Cell(mass=5.0)
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'at_pick')
    empty = '1'

    def unaware():
        cell.supervisor.policy.estimate(cell.now, load_vector(0.0), covariance_of(0.05, 0.005))
        cell.supervisor.policy.status(cell.now, 'DETERMINED', empty)

    cell._estimate, cell.supervisor.policy._load_id = unaware, empty
    cell.supervisor.policy.expect_change()
    take, cell.arm.take = cell.arm.take, lambda *a: None
    assert cell.run(5.0, lambda c: c.supervisor.tries == 1)
    cell.run(0.5)
    assert cell.supervisor.policy.belief.source == 'rated'
    assert cell.supervisor.move.basis == 'rated'
    # Half a second in which the arm does move tells.
    cell.arm.take = take
    assert cell.run(5.0, lambda c: c.supervisor.policy.belief.source == 'estimate')
    assert np.abs(cell.arm.state(cell.now)[1]).max() > 0.1


@pytest.mark.parametrize('joint, velocities, trusted', [
    (1, True, True), (5, True, False), (1, False, True), (5, False, False)])
def test_only_joints_that_carry_the_load_confirm_it(joint, velocities, trusted):
    """With and without measured velocities; the last joint of this arm carries none."""
    cell = Cell()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'at_pick')
    supervisor, q = cell.supervisor, cell.arm.state(cell.now)[0]
    v = 0.3 * (np.arange(6) == joint)
    supervisor.policy.expect_change()
    supervisor._run = SimpleNamespace()    # A motion is under way.
    for k in range(1, 101):
        now = cell.now + 0.01 * k
        supervisor.measured(now, q + 0.01 * k * v, v if velocities else np.full(6, np.nan))
        supervisor.policy.estimate(now, load_vector(0.0), covariance_of(0.05, 0.005))
        supervisor.policy.status(now, 'DETERMINED', supervisor.policy._load_id)
        supervisor.policy.residual(now)
        supervisor.policy.update(now, supervisor._shows_load(now))
    assert (supervisor.policy.belief.source == 'estimate') == trusted


def test_a_motion_while_the_hand_grips_tells_of_before():
    cell = Cell()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'at_pick')
    supervisor, (q, _, _) = cell.supervisor, cell.arm.state(cell.now)
    now = cell.now + 0.01
    supervisor.measured(now, q, 0.3 * (np.arange(6) == 1))
    supervisor.policy.expect_change()
    assert supervisor.policy.expecting and not supervisor.moving
    assert not supervisor._shows_load(now)


@pytest.mark.parametrize('ahead, judged', [(0.03, True), (0.06, False), (0.19, False)])
def test_residual_torques_that_cannot_be_judged_do_not_count_as_heard(ahead, judged):
    """Of a stamp ahead of all that is expected by now nobody knows what was expected."""
    cell = Cell()
    heard = cell.supervisor.residual
    cell.supervisor.residual = lambda now, torque: heard(now + ahead, torque)
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'to_pick')
    cell.run(0.3)
    assert ('nothing is expected' in cell.supervisor.policy.blind) != judged
    cell.arm.push = np.array([0.0, 0.0, 200.0, 0.0, 0.0, 0.0])
    assert cell.run(1.0, lambda c: c.supervisor.phase == 'stopped') == judged


def test_stop_brakes_a_motion_and_is_silent_at_rest():
    cell = Cell()
    assert cell.supervisor.stop() is None
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying')
    cell.run(0.3)
    brake = cell.supervisor.stop()
    assert np.max(np.abs(brake.velocity[0])) > 0.1 and not brake.velocity[-1].any()


def test_picking_a_load_up_is_no_collision():
    for mass in (0.5, 6.0, 12.0):
        cell = Cell(mass=mass)
        assert cell.run(60.0, lambda c: c.supervisor.phase == 'done'), cell.supervisor.stop_reason


SHIPPED = read_model(find_shared('ur10e', 'models'))


@pytest.mark.parametrize('celsius', [-5.0, 55.0])
@pytest.mark.parametrize('missing', [True, False])
def test_a_cold_or_warm_arm_is_no_collision_even_when_its_temperature_is_unknown(missing, celsius):
    cell, warmth = Cell(model=SHIPPED), np.full(6, celsius)
    told = np.full(6, np.nan) if missing else warmth
    cell.supervisor.temperature[:] = told
    exact = cell.arm.residual

    def residual(now):
        state = cell.arm.state(now)
        return exact(now) + SHIPPED.torque(*state, warmth) - SHIPPED.torque(*state, told)

    cell.arm.residual = residual
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done'), cell.supervisor.stop_reason


class LateArm(FakeArm):
    """Sets off `LATE` after the trajectory was sent; until then its friction holds a torque."""

    LATE = 0.25  # [s]

    def __init__(self, model, position):
        super().__init__(model, position)
        self._coming = []

    def take(self, trajectory, now):
        """Follow the trajectory, but later."""
        self._coming.append((now + self.LATE, trajectory))

    def state(self, now):
        """Return q, v, a (n,) at `now` [s]."""
        while self._coming and self._coming[0][0] <= now:
            super().take(self._coming.pop(0)[1], now)
        return super().state(now)

    def residual(self, now):
        """Return the torque (n,) left over by a model that knows no friction at rest."""
        q, v, _ = self.state(now)
        held = SHIPPED.torque(q, np.full(6, 0.05), np.zeros(6)) \
            - SHIPPED.torque(q, np.zeros(6), np.zeros(6))
        return super().residual(now) + np.where(v, 0.0, held)


def test_friction_of_an_arm_that_sets_off_late_is_no_collision():
    cell = Cell(model=SHIPPED, plan=PlanSettings(speed_scale=0.3))
    cell.arm = LateArm(SHIPPED, HOME)
    assert cell.run(40.0, lambda c: c.supervisor.phase == 'done'), cell.supervisor.stop_reason
