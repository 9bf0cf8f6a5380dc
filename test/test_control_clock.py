"""A clock that goes back, and a controller that is kept from running: what was sent goes on."""

import numpy as np
import pytest
from supervisor_helpers import Cell, TICK

from hand_load_estimator.control.acceleration_limits import PlanSettings
from hand_load_estimator.control.braking import braking_trajectory
from hand_load_estimator.control.measured_state import MeasuredState


@pytest.fixture
def cell():
    cell = Cell(plan=PlanSettings(speed_scale=0.2))
    assert cell.run(20.0, lambda c: c.supervisor.phase == 'to_pick')
    cell.run(0.3)
    assert np.abs(cell.arm.state(cell.now)[1]).max() > 0.3
    assert cell.supervisor.move.duration > 1.5
    return cell


def stalled(cell, heard=True):
    """Keep the supervisor from running for a while, in which the arm moves on."""
    cell.now += 0.55
    hearing, cell.hearing = cell.hearing, heard
    cell.run(TICK)
    cell.hearing = hearing
    assert cell.supervisor.counts['late_tick'] == 1


def set_ahead(cell):
    """Set the clock ahead under an arm that moves on as before."""
    sent = len(cell.sent)
    cell.now += 6.0
    cell.arm._plan = cell.arm._plan.shifted(6.0)
    cell.hearing = False
    cell.run(TICK)
    cell.hearing = True
    assert cell.supervisor.counts['late_tick'] == 1 and len(cell.sent) == sent
    cell.run(TICK)
    assert cell.supervisor.counts['clock_jump'] == 1


def turned_back(cell):
    """Turn the clock back under an arm that moves on."""
    cell.now -= 40.0
    cell.arm._plan = cell.arm._plan.shifted(-40.0)
    cell.run(TICK)
    assert cell.supervisor.counts['clock_jump'] == 1


def pushed(cell):
    """Let the supervisor hear of a push between two ticks."""
    for later in (0.002, 0.004, 0.006):
        cell.supervisor.residual(cell.now + later, np.full(6, 300.0))


@pytest.mark.parametrize('happen', [stalled, turned_back, set_ahead])
def test_a_motion_under_way_is_finished_and_not_begun_anew(cell, happen):
    motions = cell.supervisor.counts['motions']
    happen(cell)
    assert cell.supervisor.moving
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'at_pick')
    assert cell.supervisor.counts['motions'] == motions
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')
    assert not cell.supervisor.counts['stops'] + cell.supervisor.counts['off_path']


@pytest.mark.parametrize('happen', [stalled, turned_back, set_ahead])
def test_a_collision_after_it_stops_the_arm(cell, happen):
    happen(cell)
    goal, sent = cell.supervisor.move.goal, len(cell.sent)
    cell.arm.push = np.array([0.0, 0.0, 200.0, 0.0, 0.0, 0.0])
    assert cell.run(0.2, lambda c: c.supervisor.phase == 'stopped')
    cell.run(2.5)
    assert len(cell.sent) == sent + 1
    q, v, _ = cell.arm.state(cell.now)
    assert not v.any() and np.abs(q - goal).max() > 0.1


def test_a_collision_under_a_clock_set_ahead_is_braked_from_where_the_arm_is(cell):
    """The tick that hears of it cannot tell yet whether 6 s have passed or none."""
    cell.now += 6.0
    cell.arm._plan = cell.arm._plan.shifted(6.0)
    sent, cell.hearing = len(cell.sent), False
    cell.run(TICK)
    pushed(cell)
    cell.run(TICK)
    assert cell.supervisor.detector.collided and len(cell.sent) == sent
    cell.hearing = True
    assert cell.run(2 * TICK, lambda c: c.supervisor.phase == 'stopped')
    (brake, (q, v, _)), = cell.sent[sent:]
    np.testing.assert_allclose(brake.position[0], q, atol=0.01)
    np.testing.assert_allclose(brake.velocity[0], v, atol=0.05)


def test_a_collision_on_a_slow_machine_is_braked_at_once(cell):
    """A joint state that has just come says where the arm is, however late the tick."""
    cell.run(TICK)
    pushed(cell)
    cell.now += 0.6
    cell.run(TICK)
    assert cell.supervisor.counts['late_tick'] == 1 and cell.supervisor.phase == 'stopped'


@pytest.mark.parametrize('ahead, back', [(6.0, 6.0), (6.0, 5.9), (6.0, 0.03), (0.6, 0.02)])
def test_a_clock_set_ahead_and_back_before_a_joint_state_changes_nothing(cell, ahead, back):
    sent, cell.hearing = len(cell.sent), False
    for step in (ahead, -back):
        cell.now += step
        cell.arm._plan = cell.arm._plan.shifted(step)
        cell.run(TICK)
    cell.hearing = True
    assert cell.run(10.0, lambda c: c.supervisor.phase == 'at_pick') and len(cell.sent) == sent
    counts = cell.supervisor.counts
    assert not counts['stops'] + counts['off_path'] + counts['not_arrived']


def test_a_clock_set_ahead_and_back_holds_no_brake_up(cell):
    cell.hearing = False
    for step in (6.0, -6.0):
        cell.now += step
        cell.arm._plan = cell.arm._plan.shifted(step)
        cell.run(TICK)
    pushed(cell)
    assert cell.run(0.08, lambda c: c.supervisor.phase == 'stopped')


def test_a_collision_without_joint_states_is_braked_all_the_same(cell):
    cell.now += 0.6
    cell.hearing = False
    cell.run(TICK)
    pushed(cell)
    assert cell.run(0.08, lambda c: c.supervisor.phase == 'stopped')


@pytest.mark.parametrize('happen', [stalled, turned_back, set_ahead])
def test_the_end_of_the_node_after_it_stops_the_arm(cell, happen):
    happen(cell)
    _, v, _ = cell.arm.state(cell.now)
    brake = cell.supervisor.stop()
    np.testing.assert_allclose(brake.velocity[0], v, atol=1e-9)


def test_joint_states_that_wait_behind_a_late_tick_have_not_stopped(cell):
    stalled(cell, heard=False)
    cell.run(TICK)
    assert cell.supervisor.phase == 'to_pick'


def test_joint_states_that_have_stopped_stop_the_arm_soon_after(cell):
    cell.hearing = False
    stalled(cell, heard=False)
    cell.run(0.6)
    assert cell.supervisor.phase == 'stopped' and 'joint states' in cell.supervisor.stop_reason


def test_a_simulation_begun_anew_elsewhere_goes_on_with_the_cycle(cell):
    q = cell.arm.state(cell.now)[0]
    cell.now -= 40.0
    cell.arm._plan, cell.arm._rest = None, q
    assert cell.run(30.0, lambda c: c.supervisor.phase == 'done')
    assert cell.supervisor.counts['clock_jump'] == 1


def test_a_brake_begins_where_the_arm_is_by_now():
    state = MeasuredState()
    state.take(10.0, np.array([0.1, 0.2]), np.array([1.0, np.nan]))
    np.testing.assert_allclose(state.at(10.03), [0.13, 0.2])


def test_a_stop_that_no_torque_suffices_for_is_a_short_one_all_the_same():
    """Holding a load alone may take more than is allowed; 2 s of travel make that no better."""
    class Overloaded:
        def worst(self, q, v, a):
            return 1.06 + 0.002 * np.abs(a).max()

    q, v = np.zeros(6), np.array([1.04, 0.0, 0.0, 0.0, 0.0, 0.0])
    stop = braking_trajectory(q, v, Overloaded(), np.full(6, 40.0))
    assert stop.duration < 0.4 and stop.position[-1][0] < 0.25
