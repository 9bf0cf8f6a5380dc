"""The whole cycle against a fake arm: phases, limits of the next motion, stops, bad input."""

from dataclasses import replace

import numpy as np
import pytest
from control_helpers import (FAR_PICK, FAR_PLACE, HOME, FakeArm, FakeModel, covariance_of,
                             load_vector)

from hand_load_estimator.control.acceleration_limits import PlanSettings
from hand_load_estimator.control.pick_place import PHASES
from hand_load_estimator.control.supervisor import CycleSettings, Supervisor
from hand_load_estimator.load import products_from_message
from hand_load_estimator.model_file import read_model
from hand_load_estimator.shared_files import find_shared
from hand_load_estimator.trajectory import Trajectory

MODEL = FakeModel(agility=3.0)
WAYPOINTS = {'home': HOME, 'pick': FAR_PICK, 'place': FAR_PLACE}
TICK = 0.01


class Cell:
    """Supervisor, fake arm and a fake estimator that is right after a moment of motion."""

    def __init__(self, mass=2.0, start=HOME, model=MODEL, waypoints=WAYPOINTS, **settings):
        self.supervisor = Supervisor(model, CycleSettings(waypoints, dwell=0.5, home_dwell=0.2,
                                                          **settings))
        self.supervisor.start()
        self.arm, self.now, self.mass = FakeArm(model, start), 50.0, mass
        self.estimating, self.hearing, self.ready = True, True, True
        self.residuals, self.velocities, self.sent = True, True, []
        self.phases, self.limits = [], {}
        self._load_id, self._moved = 0, 0.0
        self._residuals = [self.arm.residual(self.now)] * 3

    def run(self, seconds, until=lambda cell: False):
        for _ in range(round(seconds / TICK)):
            self._step()
            if until(self):
                return True
        return False

    def _step(self):
        self.now += TICK
        self._grip()
        q, v, _ = self.arm.state(self.now)
        if self.hearing:
            self.supervisor.measured(self.now, q, v if self.velocities else np.full(6, np.nan))
            # Late by the estimator's filter.
            if self.residuals:
                self.supervisor.residual(self.now, self._residuals[-1])
            self._residuals = [self.arm.residual(self.now), *self._residuals[:-1]]
        if self.estimating:
            self._estimate()
        trajectory = self.supervisor.tick(self.now, self.ready)
        if trajectory is not None:
            self.sent.append((trajectory, self.arm.state(self.now)))
        if trajectory is not None and self.ready:
            self.arm.take(trajectory, self.now)
        if not self.phases or self.phases[-1] != self.supervisor.phase:
            self.phases.append(self.supervisor.phase)
        self.limits[self.supervisor.phase] = self.supervisor.limits

    def _grip(self):
        held = self.arm.load[0] > 0.0
        wanted = self.supervisor.phase in ('at_pick', 'carrying') or (
            held and self.supervisor.phase == 'stopped')
        if held != wanted:
            self.arm.load = products_from_message(load_vector(self.mass)) * wanted
            self._load_id, self._moved = self._load_id + 1, 0.0

    def _estimate(self):
        policy, moving = self.supervisor.policy, self.supervisor.moving
        self._moved += TICK * moving
        known = self._moved > 0.15
        std = 0.05 if known else 5.0
        mass = self.arm.load[0] if known else 4.0
        policy.estimate(self.now, load_vector(mass), covariance_of(std, 0.005 if known else 0.1))
        policy.status(self.now, 'DETERMINED' if known else 'WAITING_FOR_MOTION',
                      str(self._load_id))


def test_one_cycle_goes_through_its_phases_and_ends():
    cell = Cell()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')
    assert cell.phases == [p for p in PHASES if p not in ('waiting', 'stopped')]
    np.testing.assert_allclose(cell.arm.state(cell.now)[0], HOME, atol=1e-6)
    taken = cell.arm.taken
    cell.run(2.0)
    assert cell.arm.taken == taken and not cell.supervisor.detector.collided


def test_cycles_without_end_go_on():
    cell = Cell(cycles=0)
    cell.run(30.0)
    assert cell.phases.count('carrying') >= 3 and 'done' not in cell.phases


def test_it_drives_home_first_from_anywhere():
    cell = Cell(start=HOME + 0.4)
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'to_pick')
    assert cell.supervisor.counts['motions'] == 1
    np.testing.assert_allclose(cell.arm.state(cell.now)[0], HOME, atol=1e-6)


def test_the_motion_under_way_is_planned_anew_when_its_load_is_known():
    light, heavy, blind = Cell(mass=1.0), Cell(mass=9.0), Cell(mass=1.0)
    blind.estimating = False
    seconds = {}
    for name, cell in (('light', light), ('heavy', heavy), ('blind', blind)):
        assert cell.run(40.0, lambda c: c.supervisor.phase == 'carrying')
        begin = cell.now
        assert cell.run(20.0, lambda c: c.supervisor.phase == 'at_place')
        seconds[name] = cell.now - begin
    assert light.supervisor.counts['replans'] >= 1
    assert seconds['light'] < seconds['blind'] - 0.1
    assert np.all(light.limits['carrying'].deceleration >= heavy.limits['carrying'].deceleration)
    assert light.supervisor.move.basis == 'estimate' and blind.supervisor.move.basis == 'rated'


def test_what_is_sent_never_jumps():
    cell = Cell(mass=1.0)
    states = []
    cell.run(20.0, lambda c: states.append(c.arm.state(c.now)) or c.supervisor.phase == 'done')
    q, v, _ = (np.array(x) for x in zip(*states))
    assert cell.supervisor.counts['replans'] >= 1
    assert np.max(np.abs(np.diff(q, axis=0))) < 1.05 * TICK * MODEL.robot.limits.velocity.max()
    top = np.max(MODEL.robot.limits.acceleration)
    assert np.max(np.abs(np.diff(v, axis=0))) < 1.3 * TICK * top


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


def test_limits_are_known_before_the_first_move_and_fall_back_with_the_load():
    cell = Cell(mass=1.0)
    rated, robot = cell.supervisor.limits, MODEL.robot
    assert np.all(rated.acceleration > 0.0)
    assert np.all(rated.deceleration < 0.9 * robot.limits.acceleration)
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying'
                    and c.supervisor.policy.trusted and c.supervisor.move.basis == 'estimate')
    light = cell.supervisor.limits
    assert light is not rated and np.all(light.deceleration > rated.deceleration)
    cell.supervisor.policy.status(cell.now, 'STALE_INPUT', '1')
    assert cell.supervisor.limits is rated
    cell.run(0.02)
    assert cell.supervisor.limits is not rated


def test_without_residual_torques_moves_keep_the_rated_limits():
    cell, seeing = Cell(mass=1.0), Cell(mass=1.0)
    cell.residuals = False
    seconds = {}
    for each in (cell, seeing):
        assert each.run(40.0, lambda c: c.supervisor.phase == 'carrying')
        begin = each.now
        assert each.run(20.0, lambda c: c.supervisor.phase == 'at_place')
        seconds[each] = each.now - begin
    assert cell.supervisor.move.basis == 'rated' and cell.supervisor.policy.blind
    assert not seeing.supervisor.policy.blind
    assert seconds[cell] > seconds[seeing] + 0.1


def test_nothing_moves_before_joint_states_and_a_listener():
    cell = Cell()
    cell.hearing = cell.ready = False
    cell.run(1.0)
    cell.hearing = True
    cell.run(1.0)
    assert cell.arm.taken == 0 and cell.supervisor.counts['motions'] == 0
    cell.ready = True
    assert cell.run(2.0, lambda c: c.arm.taken == 1)


def test_an_arm_that_somebody_else_still_moves_is_waited_for():
    cell = Cell(start=HOME + 0.4)
    swing = Trajectory([0.0, 2.0], [HOME + 0.4, HOME], np.zeros((2, 6)), np.zeros((2, 6)))
    cell.arm.take(swing, cell.now - 0.8)
    cell.run(0.6)
    assert cell.supervisor.counts['motions'] == 0
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'at_pick')


def test_a_trajectory_that_was_lost_is_sent_again():
    cell = Cell()
    take, lost = cell.arm.take, []
    cell.arm.take = lambda *a: lost.append(a) if len(lost) < 1 else take(*a)
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'at_pick')
    counts = cell.supervisor.counts
    assert counts['off_path'] + counts['not_arrived'] >= 1


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


def test_an_arm_without_velocities_that_somebody_moves_is_waited_for():
    cell = Cell(start=HOME + 0.4)
    cell.velocities = False
    cell.arm.take(Trajectory([0.0, 2.0], [HOME + 0.4, HOME], np.zeros((2, 6)), np.zeros((2, 6))),
                  cell.now - 0.8)
    cell.run(0.6)
    assert cell.supervisor.counts['motions'] == 0
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'at_pick')


def test_what_is_held_beside_the_estimate_counts():
    cell = Cell(mass=3.0)
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying'
                    and c.supervisor.policy.trusted)
    policy, before = cell.supervisor.policy, cell.supervisor.policy.belief
    # The status of a tare is here before the load it declared zero is, or after it.
    policy.status(cell.now, 'DETERMINED', '1', 3.0)
    policy.update(cell.now, True)
    assert 'are known here' in policy.reason and policy.belief.source == 'rated'
    policy.status(cell.now, 'DETERMINED', '1', float('nan'))
    policy.update(cell.now, True)
    assert not policy.trusted
    policy.status(cell.now, 'DETERMINED', '1', 3.0)
    policy.known = before.mean.copy()
    policy.update(cell.now, True)
    assert policy.trusted
    np.testing.assert_allclose(policy.belief.mean, 2.0 * before.mean)
    np.testing.assert_array_equal(policy.belief.covariance, before.covariance)


def test_a_clock_that_jumps_back_does_not_end_the_cycle():
    cell = Cell()
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'carrying')
    cell.run(0.2)
    q = cell.arm.state(cell.now)[0]
    cell.now -= 40.0
    cell.arm._plan, cell.arm._rest = None, q
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')
    assert cell.supervisor.counts['clock_jump'] == 1


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


def test_settings_are_used():
    assert replace(CycleSettings(WAYPOINTS), cycles=3).cycles == 3
    cell = Cell(cycles=2)
    assert cell.run(60.0, lambda c: c.supervisor.phase == 'done')
    assert cell.phases.count('at_pick') == 2
