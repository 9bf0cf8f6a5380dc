"""The whole cycle against a fake arm: phases, limits of the next motion, waiting, going on."""

from dataclasses import replace

from control_helpers import HOME
import numpy as np
from supervisor_helpers import Cell, MODEL, TICK, WAYPOINTS

from hand_load_estimator.control.supervisor import CycleSettings
from hand_load_estimator.motions.trajectory import Trajectory


def test_one_cycle_goes_through_its_phases_and_ends():
    cell = Cell()
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')
    assert cell.phases == ['home', 'to_pick', 'at_pick', 'carrying', 'at_place', 'returning',
                           'done']
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


def test_settings_are_used():
    assert replace(CycleSettings(WAYPOINTS), cycles=3).cycles == 3
    cell = Cell(cycles=2)
    assert cell.run(60.0, lambda c: c.supervisor.phase == 'done')
    assert cell.phases.count('at_pick') == 2
