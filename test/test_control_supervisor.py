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
from hand_load_estimator.trajectory import Trajectory

MODEL = FakeModel(agility=3.0)
WAYPOINTS = {'home': HOME, 'pick': FAR_PICK, 'place': FAR_PLACE}
TICK = 0.01


class Cell:
    """Supervisor, fake arm and a fake estimator that is right after a moment of motion."""

    def __init__(self, mass=2.0, start=HOME, **settings):
        self.supervisor = Supervisor(MODEL, CycleSettings(WAYPOINTS, dwell=0.5, home_dwell=0.2,
                                                          **settings))
        self.arm, self.now, self.mass = FakeArm(MODEL, start), 50.0, mass
        self.estimating, self.hearing, self.ready = True, True, True
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
            self.supervisor.measured(self.now, q, v)
            # Late by the estimator's filter.
            self.supervisor.residual(self.now, self._residuals[-1])
            self._residuals = [self.arm.residual(self.now), *self._residuals[:-1]]
        if self.estimating:
            self._estimate()
        trajectory = self.supervisor.tick(self.now, self.ready)
        if trajectory is not None and self.ready:
            self.arm.take(trajectory, self.now)
        if not self.phases or self.phases[-1] != self.supervisor.phase:
            self.phases.append(self.supervisor.phase)
        if self.supervisor.limits is not None:
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
    assert cell.phases == [p for p in PHASES if p != 'stopped'][:6] + ['done']
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
    cell.supervisor.reset()
    assert not cell.supervisor.detector.collided
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')


def test_joint_states_that_stop_while_moving_stop_the_arm():
    cell = Cell(plan=PlanSettings(speed_scale=0.2))
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'to_pick' and c.supervisor.moving)
    cell.hearing = False
    assert cell.run(1.0, lambda c: c.supervisor.phase == 'stopped')
    assert 'joint states have stopped' in cell.supervisor.stop_reason


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


@pytest.mark.parametrize('missing', [True, False])
def test_temperatures_may_be_missing(missing):
    cell = Cell()
    cell.supervisor.temperature[:] = np.nan if missing else 40.0
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')


def test_settings_are_used():
    assert replace(CycleSettings(WAYPOINTS), cycles=3).cycles == 3
    cell = Cell(cycles=2)
    assert cell.run(60.0, lambda c: c.supervisor.phase == 'done')
    assert cell.phases.count('at_pick') == 2
