"""The input guard: usable joint states pass in the robot's order, others are counted by kind."""

from core_helpers import block, exact_model, four_axes, messages
from types import SimpleNamespace

import numpy as np
import pytest

from hand_load_estimator.stream.input_guard import InputGuard
from hand_load_estimator.stream.joint_stream import JointStream

JOINTS = ('pan', 'lift', 'roll')
Q, V, TAU = [0.1, 0.2, 0.3], [1.0, 2.0, 3.0], [10.0, 20.0, 30.0]


@pytest.fixture
def guard():
    three = np.ones(3)
    return InputGuard(SimpleNamespace(
        joints=JOINTS, effort=SimpleNamespace(torque_constants=three),
        limits=SimpleNamespace(velocity=3.0 * three, torque=1e3 * three),
        turning=np.array([True, True, False]),
        stops=np.array([-1e3 * three, [1e3, 1e3, np.inf]])))


def accept(guard, stamp=1.0, names=JOINTS, position=Q, velocity=V, effort=TAU):
    return guard.accept(stamp, names, position, velocity, effort)


def test_a_good_message_passes(guard):
    for got, wanted in zip(accept(guard), (Q, V, TAU)):
        np.testing.assert_array_equal(got, wanted)
    assert not guard.rejected


@pytest.mark.parametrize('names, picks', [
    (('roll', 'pan', 'lift'), [1, 2, 0]),
    (('left/roll', 'left/pan', 'left/lift'), [1, 2, 0]),
    (('finger', 'roll', 'pan', 'lift', 'rail'), [2, 3, 1]),
    (('ur_pan', 'ur_lift', 'ur_roll', 'ur_finger'), [0, 1, 2]),
    # A second arm whose names end alike must not shadow exact names.
    (('left_pan', 'left_lift', 'left_roll', 'pan', 'lift', 'roll'), [3, 4, 5])])
def test_joints_are_found_by_name(guard, names, picks):
    values = np.arange(len(names), dtype=float)
    q, v, tau = guard.accept(1.0, names, values, values / 10, values * 10)
    np.testing.assert_array_equal(q, values[picks])
    np.testing.assert_array_equal(v, values[picks] / 10)
    np.testing.assert_array_equal(tau, values[picks] * 10)


def test_other_joints_messages_are_passed_over_and_counted_apart(guard):
    assert accept(guard, names=('finger', 'thumb', 'rail')) is None
    assert not guard.rejected and guard.passed_over == 1
    assert accept(guard) is not None


@pytest.mark.parametrize('messages, reason', [
    ([], 'no joint states yet'),
    ([('lwr_0', 'lwr_1', 'lwr_2')],
     'joint states name lwr_0, lwr_1, lwr_2, but none of pan, lift, roll'),
    ([('finger',), ('pan', 'lift', 'x')],
     'joint states name finger, pan, lift, x, but never all of pan, lift, roll'),
    ([()], 'joint states name no joint; wanted: pan, lift, roll'),
    ([('l_pan', 'r_pan', 'l_lift', 'r_lift', 'l_roll', 'r_roll'), ('finger',)],
     "joint states arrive, but none is usable; rejected: 1 ambiguous joint; a message has joint "
     "states of more arms than one, behind 'l_', 'r_'; name the joints in the robot file with the "
     'prefix of one of them')])
def test_why_no_joint_state_is_usable_is_told(guard, messages, reason):
    """Of another arm's joint states it was said that none had come yet."""
    for names in messages:
        assert accept(guard, names=names) is None
    assert guard.why_none == reason


def test_joint_states_without_effort_are_told_as_such(guard):
    accept(guard, names=('finger',))
    accept(guard, effort=[])
    assert guard.why_none == 'joint states arrive, but none is usable; rejected: 1 short arrays'


def test_many_names_are_not_all_told(guard):
    for k in range(1000):
        accept(guard, names=(f'joint_{k}',))
    assert 'joint_9 and others, but none of' in guard.why_none and len(guard.why_none) < 200
    assert guard.passed_over == 1000


NAN = float('nan')
BAD = {
    'missing_joint': dict(names=('pan', 'lift', 'x')),
    'ambiguous_joint': dict(names=('l_pan', 'r_pan', 'l_lift', 'r_lift', 'l_roll',
                                   'r_roll'),
                            position=Q * 2, velocity=V * 2, effort=TAU * 2),
    'short_arrays': dict(position=Q[:2]),
    'not_finite': dict(position=[NAN, 0.0, 0.0]),
    'implausible_velocity': dict(velocity=[0.0, 16.0, 0.0])}
ALSO_BAD = [
    ('short_arrays', dict(effort=[])), ('short_arrays', dict(velocity=V[:1])),
    ('short_arrays', dict(effort=TAU + [1.0])), ('not_finite', dict(effort=[0.0, NAN, 0.0])),
    ('not_finite', dict(stamp=NAN)),
    ('not_finite', dict(position=[float('inf'), 0.0, 0.0]))]


@pytest.mark.parametrize('reason, message', [*BAD.items(), *ALSO_BAD])
def test_bad_messages_are_counted_by_kind_and_the_next_good_one_passes(guard, reason, message):
    assert accept(guard, **message) is None
    assert dict(guard.rejected) == {reason: 1}
    assert accept(guard, stamp=2.0) is not None
    assert dict(guard.rejected) == {reason: 1}


def test_two_arms_half_of_each_are_not_one_arm(guard):
    """A message with some joints of the left and others of the right arm is nobody's state."""
    assert accept(guard, names=('left_pan', 'right_lift', 'left_roll')) is None


def test_a_message_without_velocity_passes_and_says_so(guard):
    q, v, tau = accept(guard, velocity=[])
    assert np.isnan(v).all() and np.isfinite(q).all() and np.isfinite(tau).all()
    assert not guard.rejected


def test_repeated_and_backward_stamps(guard):
    assert accept(guard, 1.0) is not None
    assert accept(guard, 1.0) is None and accept(guard, 0.99) is None
    assert dict(guard.rejected) == {'repeated_stamp': 1, 'backward_stamp': 1}
    assert accept(guard, 1.01) is not None and not guard.restarted


def test_a_restarted_clock_is_followed(guard):
    accept(guard, 100.0)
    assert accept(guard, 3.0) is not None
    assert guard.restarted and dict(guard.rejected) == {'clock_restart': 1}
    assert accept(guard, 3.01) is not None and not guard.restarted


def test_one_stamp_from_the_future_does_not_lock_out_the_present(guard):
    accept(guard, 10.0)
    accept(guard, 99999.0)
    assert accept(guard, 10.01) is not None
    assert accept(guard, 10.02) is not None


def stream_of(robot, stream):
    joint_stream, samples = JointStream(robot), []
    for m in stream:
        sample = joint_stream.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
        if sample is not None:
            samples.append(sample)
    return joint_stream, samples


def test_a_gap_is_counted_and_restarts_the_filter():
    model = exact_model('four')
    stream = messages(model, block(1.0), 2.0)
    joint_stream, samples = stream_of(model.robot, stream[:80] + stream[120:])
    assert joint_stream.rejected == {'gap': 1}
    fresh = [s.stamp - 100.0 for s in samples if s.fresh]
    assert all(t < 0.1 or 1.2 <= t < 1.3 for t in fresh) and any(t > 1.2 for t in fresh)
    assert max(s.dt for s in samples) < 0.03


def test_a_restarted_clock_restarts_the_filter():
    model = exact_model('four')
    stream = messages(model, block(1.0), 2.0)
    joint_stream, samples = stream_of(model.robot, stream + stream)
    assert joint_stream.rejected == {'clock_restart': 1}
    assert all(s.dt > 0.0 for s in samples)
    first, second = samples[:len(samples) // 2], samples[len(samples) // 2:]
    # The weights of position and velocity are what the noise has taught; all else begins anew.
    for name in ('q', 'effort', 'fresh'):
        np.testing.assert_array_equal(*([getattr(s, name) for s in half]
                                        for half in (first, second)))


@pytest.mark.parametrize('celsius', [NAN, 300.0, -300.0, float('inf')])
def test_broken_temperatures_are_counted_and_not_used(celsius):
    robot = four_axes()
    stream = JointStream(robot)
    stream.temperature_reading('j1', 31.0)
    stream.temperature_reading('j1', celsius)
    assert stream.rejected == {'implausible_temperature': 1}
    np.testing.assert_array_equal(stream.temperature, [NAN, 31.0, NAN, NAN])


def test_zero_for_no_temperature_is_none():
    """It is far outside of what the model of a warm arm was identified at."""
    stream = JointStream(four_axes())
    stream.temperature_reading('j0', 0.0)
    stream.temperature_reading('j1', 31.0)
    stream.temperature_reading('j1', 0.0)
    assert stream.rejected == {'zero_temperature': 2}
    np.testing.assert_array_equal(stream.temperature, [NAN, 31.0, NAN, NAN])


def test_an_arm_that_freezes_may_be_at_zero():
    stream = JointStream(four_axes())
    for celsius in (1.0, 0.0, -1.0, 0.0):
        stream.temperature_reading('j1', celsius)
        assert stream.temperature[1] == celsius
    assert not stream.rejected


def test_temperatures_of_others_are_passed_over_and_prefixes_found():
    stream = JointStream(four_axes())
    stream.temperature_reading('gripper', 31.0)
    stream.temperature_reading('left_j2', 40.0)
    assert not stream.rejected
    np.testing.assert_array_equal(stream.temperature, [NAN, NAN, 40.0, NAN])


def test_another_arms_temperature_is_not_taken_for_ones_own():
    stream = JointStream(four_axes())
    stream.temperature_reading('left_j1', 30.0)
    stream.temperature_reading('right_j1', 50.0)
    np.testing.assert_array_equal(stream.temperature, [NAN, 30.0, NAN, NAN])
    stream.temperature_reading('j1', 40.0)
    stream.temperature_reading('left_j1', 30.0)
    np.testing.assert_array_equal(stream.temperature, [NAN, 40.0, NAN, NAN])
    assert not stream.rejected


def test_velocities_that_are_all_nan_are_none(guard):
    # As ros2_control's broadcaster fills in for joints without that interface.
    q, v, tau = accept(guard, velocity=np.full(len(JOINTS), NAN))
    np.testing.assert_array_equal(q, Q)
    assert np.isnan(v).all() and not guard.rejected


@pytest.mark.parametrize('joint', range(3))
def test_without_the_velocity_of_one_joint_all_are_done_without(guard, joint):
    """A joint whose hardware has no such interface; a broken reading of one that has is none."""
    some = np.array(V, dtype=float)
    some[joint] = NAN
    for stamp in (1.0, 1.1):
        q, v, _ = accept(guard, stamp=stamp, velocity=some)
        assert np.isnan(v).all() and np.isfinite(q).all() and not guard.rejected
    assert np.isfinite(accept(guard, stamp=1.2)).all()
    assert accept(guard, stamp=1.3, velocity=some) is None
    assert guard.rejected == {'not_finite': 1}


def test_a_joint_without_stops_counts_its_turns_on(guard):
    assert accept(guard, position=[0.1, 0.2, 5e3]) is not None
    assert accept(guard, stamp=2.0, position=[5e3, 0.2, 5e3]) is None
    assert accept(guard, stamp=3.0, position=[0.1, 0.2, np.inf]) is None
    assert guard.rejected == {'implausible_position': 1, 'not_finite': 1}


def test_invented_names_do_not_fill_the_memory(guard):
    for k in range(1000):
        accept(guard, names=[f'{name}_{k}' for name in JOINTS])
    assert len(guard.names._places) <= 100
    assert accept(guard) is not None


def test_a_temperature_not_renewed_expires_whatever_the_clock_does():
    model = exact_model('four')
    still = messages(model, block(1.0), 0.1)[0]
    stream = JointStream(model.robot)

    def feed(begin, seconds, warm=()):
        for k in range(int(10.0 * seconds)):
            stream.joint_state(begin + 0.1 * k, still.names, still.position, still.velocity,
                               still.effort)
            for joint in warm:
                stream.temperature_reading(joint, 30.0)

    stream.temperature_reading('j1', 31.0)
    feed(1000.0, 29.9, ('j2',))
    np.testing.assert_array_equal(stream.temperature, [NAN, 31.0, 30.0, NAN])
    feed(1030.0, 1.0)
    np.testing.assert_array_equal(stream.temperature, [NAN, NAN, 30.0, NAN])
    # Before a clock restarts and after it a reading has the same life.
    feed(5.0, 1.0, ('j3',))
    feed(6.0, 29.9)
    assert stream.temperature[3] == 30.0
    feed(36.0, 1.0)
    assert np.isnan(stream.temperature).all()
    assert stream.rejected == {'temperature_expired': 3, 'clock_restart': 1}
