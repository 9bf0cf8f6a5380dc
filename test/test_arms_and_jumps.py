"""Streams of real drivers: arms alike on one topic, whole turns, wrong messages, no velocities."""

from types import SimpleNamespace

from core_helpers import block, exact_model, feed, four_axes, messages, pipeline_of, warm
import numpy as np
from pipeline_helpers import within
import pytest

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.estimators.estimation import estimate_recording
from hand_load_estimator.estimators.pipeline import TareError
from hand_load_estimator.stream.arm_names import ArmNames, refuse_several, SILENT
from hand_load_estimator.stream.continuity import Continuity, ELSEWHERE
from hand_load_estimator.stream.input_guard import InputGuard
from hand_load_estimator.stream.joint_stream import JointStream, motion_of
from hand_load_estimator.stream.joint_temperatures import JointTemperatures

JOINTS = 'pan', 'lift'
LEFT, RIGHT = (tuple(f'{side}_{joint}' for joint in JOINTS) for side in ('left', 'right'))
STEP = 0.002
MASS = 3.0


def course(turning=True):
    return Continuity(np.full(2, 5.0), np.full(2, turning))


def test_the_arm_that_is_heard_first_is_kept():
    arm = ArmNames(JOINTS)
    assert list(arm.index(LEFT, 0.0)) == [0, 1] and arm.index(RIGHT, 0.1) is None
    assert list(arm.index(LEFT[::-1], 0.2)) == [1, 0] and arm.index(('finger',), 0.3) is None
    assert arm.prefix == 'left_' and arm.others == {'right_'} and arm.passed_over == 2
    # Silent itself, the other one is still another arm.
    assert arm.index(RIGHT, 9.0) is None


def test_joints_with_their_own_names_win():
    arm = ArmNames(JOINTS)
    assert arm.index(LEFT, 0.0) is not None
    assert arm.index(JOINTS, 0.1) is not None and arm.index(LEFT, 0.2) is None
    assert arm.prefix == '' and arm.others == {'left_'}


@pytest.mark.parametrize('before', [RIGHT, JOINTS])
def test_an_arm_that_is_heard_with_another_prefix_from_now_on_is_followed(before):
    """A driver started again with another prefix had left nothing but silence."""
    arm = ArmNames(JOINTS)
    assert arm.index(before, 0.0) is not None
    heard = [arm.index(LEFT, 0.5 * k) is not None for k in range(1, 9)]
    assert heard == [0.5 * k >= SILENT for k in range(1, 9)] and arm.prefix == 'left_'
    with pytest.raises(RecordingError, match='more arms than one'):
        refuse_several(arm, 'bag')


def test_invented_prefixes_do_not_fill_the_memory():
    arm = ArmNames(JOINTS)
    for k in range(5000):
        for prefix in ('own_', f'{k}_'):
            arm.index(tuple(prefix + joint for joint in JOINTS), 1e-3 * k)
    assert len(arm.others) <= 110 and arm.prefix == 'own_' and arm.passed_over == 5000


def test_a_state_without_efforts_tells_of_no_prefix(model, stream):
    """A publisher of positions only, by the joints' own names, had shut out the arm itself."""
    guard, first = InputGuard(model.robot), stream[0]
    nothing = np.zeros(0)
    assert guard.accept(0.0, first.names, first.position, nothing, nothing) is None
    assert guard.rejected == {'short_arrays': 1}
    for k in range(1, 5):
        ours = behind('left_', first)
        assert guard.accept(STEP * k, ours.names, ours.position, ours.velocity,
                            ours.effort) is not None
        assert guard.accept(STEP * k + 1e-3, first.names, first.position, nothing,
                            nothing) is None
    assert guard.names.prefix == 'left_' and guard.passed_over == 4


def test_a_clock_that_was_set_back_is_no_silence():
    arm = ArmNames(JOINTS)
    assert arm.index(LEFT, 100.0) is not None and arm.index(RIGHT, 100.1) is None
    assert arm.index(RIGHT, 1.0) is None and arm.index(LEFT, 1.1) is not None
    assert arm.index(RIGHT, 9.0) is None


def test_whole_turns_are_taken_out():
    """A joint that stands at half a turn flips between plus and minus of it with every noise."""
    straight, angles = course(), [3.1415, -3.1416, 3.1414, -3.1414, -3.1410]
    for k, angle in enumerate(angles):
        q = np.array([angle, 0.5])
        assert straight.follow(STEP * k, q) and straight.restarted == (k == 0)
        turns = 0.0 if straight.turns is None else straight.turns
        assert q + turns == pytest.approx([angle % (2.0 * np.pi), 0.5])


def test_what_slides_has_no_turns():
    """A rail that is told six metres from where it was has not turned around."""
    rail = course(turning=False)
    assert rail.follow(0.0, np.array([3.14, 0.0]))
    assert not rail.follow(STEP, np.array([-3.14, 0.0])) and rail.turns is None


def test_a_wrong_message_now_and_then_costs_only_itself():
    follow = course()
    for k in range(500):
        wrong = k % 50 == 20
        there = follow.follow(STEP * k, np.array([2.0 if wrong else 0.01 * k * STEP, 0.0]))
        assert there != wrong and follow.restarted == (k == 0)


def test_of_two_that_contradict_each_other_the_first_is_followed():
    follow = course()
    told = [follow.follow(STEP * k, np.full(2, float(k % 2))) for k in range(200)]
    assert told == [k % 2 == 0 for k in range(200)]


def test_an_arm_that_is_elsewhere_for_good_is_followed_there():
    follow = course()
    follow.follow(0.0, np.zeros(2))
    told = [follow.follow(0.01 + STEP * k, np.full(2, 2.0)) for k in range(100)]
    first = told.index(True)
    assert STEP * first == pytest.approx(ELSEWHERE, abs=1.5 * STEP)
    assert all(told[first:]) and not follow.restarted


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


@pytest.fixture(scope='module')
def stream(model):
    return messages(model, block(MASS), 4.0)


def changed(message, **values):
    return SimpleNamespace(**{**vars(message), **values})


def behind(prefix, message):
    return changed(message, names=tuple(prefix + name for name in message.names))


def test_of_two_arms_on_one_topic_one_is_estimated(model, stream):
    """Doing the same at once, one of them empty, they had been taken for one that holds half."""
    empty = messages(model, block(0.0), 4.0, seed=3)
    both = [m for pair in zip(stream, empty)
            for m in (behind('left_', pair[0]), changed(behind('right_', pair[1]),
                                                        stamp=pair[1].stamp + 1e-3))]
    pipeline = warm(pipeline_of(model))
    last = feed(pipeline, both)[-1]
    assert within(last, block(MASS)) and last.status == 'DETERMINED'
    assert (pipeline.names.prefix, pipeline.names.others) == ('left_', {'right_'})


def test_joints_that_stand_at_half_a_turn_do_not_stop_the_estimate(model, stream):
    turned = [changed(m, position=(m.position + np.pi * np.eye(4)[3] * (1 - 2 * (k % 2))))
              for k, m in enumerate(stream)]
    straight = [changed(m, position=m.position + np.pi * np.eye(4)[3]) for m in stream]
    ours, wanted = (feed(warm(pipeline_of(model)), those)[-1] for those in (turned, straight))
    np.testing.assert_allclose(ours.mean, wanted.mean, rtol=1e-6)


def test_who_plans_a_motion_begins_where_the_driver_says_that_the_arm_stands(model, stream):
    """A trajectory from a whole turn away would have sent the joint around."""
    guard, first = InputGuard(model.robot), stream[0]
    for k in range(5):
        reported = first.position + np.pi * np.eye(4)[3] * (1 - 2 * (k % 2))
        q, _, _ = guard.accept(STEP * k, first.names, reported, first.velocity, first.effort)
        np.testing.assert_array_equal(q, reported)
    assert guard.turns is None or not guard.turns.any()
    guard.accept(STEP * 5, first.names, first.position - np.pi * np.eye(4)[3], first.velocity,
                 first.effort)
    np.testing.assert_allclose(guard.turns, 2.0 * np.pi * np.eye(4)[3])


def test_a_suggestion_begins_where_the_driver_says_that_the_arm_stands(model, stream):
    pipeline = warm(pipeline_of(model))
    still = stream[0]
    for k in range(60):
        flip = np.pi * np.eye(4)[3] * (1.0 if k < 30 else -1.0)
        pipeline.joint_state(100.0 + 0.008 * k, still.names, still.position + flip,
                             np.zeros(4), still.effort + 1e-6 * k)
    suggestion = pipeline.suggest_motion(pipeline.last_stamp)
    np.testing.assert_allclose(suggestion.trajectory.position[0],
                               still.position - np.pi * np.eye(4)[3], atol=0.02)


def test_wrong_messages_do_not_stop_the_estimate(model, stream):
    """Zeros of a second publisher, one message in fifty, had left no estimate at all."""
    zeros = [changed(m, stamp=m.stamp + 1e-3, position=np.zeros(4), velocity=np.zeros(4),
                     effort=np.zeros(4)) for m in stream[::10]]
    pipeline = warm(pipeline_of(model))
    last = feed(pipeline, sorted([*stream, *zeros], key=lambda m: m.stamp))[-1]
    assert within(last, block(MASS)) and pipeline.rejected['position_jump'] > 20


def test_what_only_jumps_is_stale_and_says_why(model, stream):
    """A minute later it was still DETERMINED, and tare took it for what is held now."""
    pipeline = warm(pipeline_of(model))
    assert feed(pipeline, stream)[-1].status == 'DETERMINED'
    last, samples = stream[-1], pipeline.estimates
    for k in range(300):
        now, place = last.stamp + 0.008 * (k + 1), 3.0 * (1 + k // 15 % 2)
        pipeline.joint_state(now, last.names, last.position + place, last.velocity,
                             last.effort + 1e-6 * k)
    assert pipeline.estimates - samples < 5
    told = pipeline.estimate(now)
    assert told.status == 'STALE_INPUT' and 'though they arrive' in told.reason
    assert 'position jump' in told.reason
    with pytest.raises(TareError, match='STALE_INPUT'):
        pipeline.tare(now)


def test_a_driver_that_repeats_its_last_word_is_no_hand_to_tare(model, stream):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, stream)
    last = stream[-1]
    for k in range(200):
        now = last.stamp + 0.008 * (k + 1)
        pipeline.joint_state(now, last.names, last.position, last.velocity, last.effort)
    assert pipeline.frozen == pytest.approx(1.6, abs=0.02)
    with pytest.raises(TareError, match='lost its robot'):
        pipeline.tare(now)
    pipeline.joint_state(now + 0.008, last.names, last.position + 1e-9, last.velocity,
                         last.effort)
    assert pipeline.frozen == 0.0


def test_velocities_that_are_zero_while_the_arm_moves_are_none(model, stream):
    """It waited for a motion for ever."""
    zero = [changed(m, velocity=np.zeros(4)) for m in stream]
    pipeline = warm(pipeline_of(model))
    last = feed(pipeline, zero)[-1]
    assert within(last, block(MASS)) and last.status == 'DETERMINED'
    assert pipeline.velocity_stuck.all()
    feed(pipeline, [changed(m, stamp=m.stamp + 5.0) for m in stream[100:110]])
    assert not pipeline.velocity_stuck.any()


def test_an_arm_at_rest_may_report_zeros(model):
    stream = JointStream(model.robot)
    for m in messages(model, block(1.0), 1.0, rest=1.0)[:100]:
        stream.joint_state(m.stamp, m.names, m.position, np.zeros(4), m.effort)
    assert not stream.velocity_stuck.any()


def test_a_velocity_that_stays_at_zero_is_not_believed(model, stream):
    """One joint's: it was six load changes in four seconds, and twice the mass."""
    stuck = [changed(m, velocity=np.where(np.arange(4) == 1, 0.0, m.velocity)) for m in stream]
    pipeline = warm(pipeline_of(model))
    last = feed(pipeline, stuck)[-1]
    assert within(last, block(MASS)) and last.status == 'DETERMINED'
    np.testing.assert_array_equal(pipeline.velocity_stuck, np.arange(4) == 1)
    feed(pipeline, [changed(m, stamp=m.stamp + 5.0) for m in stream[100:110]])
    assert not pipeline.velocity_stuck.any()


def test_what_moved_while_nothing_was_heard_is_not_stuck(model):
    guard, arm = InputGuard(model.robot), model.robot.joints
    for stamp, place in ((0.0, 0.0), (0.01, 0.0), (0.41, 0.2), (0.42, 0.2)):
        guard.accept(stamp, arm, [0.0, place, 0.0, 0.0], [0.1, 0.0, 0.1, 0.1], [0.0] * 4)
        assert not guard.velocity_stuck.any()


def test_whose_velocity_is_measured_keeps_it_beside_one_that_is_stuck(model):
    """A controller brakes from it."""
    guard, arm = InputGuard(model.robot), model.robot.joints
    for k in range(20):
        signal = guard.accept(0.02 * k, arm, [0.0, 0.01 * k, 0.0, 0.0], [0.1, 0.0, 0.2, 0.3],
                              [0.0] * 4)
    np.testing.assert_array_equal(signal[1], [0.1, np.nan, 0.2, 0.3])


def test_one_joint_at_rest_may_report_zeros(model, stream):
    guarded, last = JointStream(model.robot), stream[0].position
    for m in stream:
        position = np.where(np.arange(4) == 1, last, m.position)
        guarded.joint_state(m.stamp, m.names, position, np.where(np.arange(4) == 1, 0.0,
                                                                 m.velocity), m.effort)
        assert not guarded.velocity_stuck.any()


def test_temperatures_belong_to_the_arm_of_the_joint_states(model, stream):
    """The first prefix heard had them, even another arm's."""
    both = JointStream(four_axes())
    both.temperature_reading('right_j1', 60.0)
    assert both.temperature[1] == 60.0
    first = behind('left_', stream[0])
    both.joint_state(first.stamp, first.names, first.position, first.velocity, first.effort)
    both.temperature_reading('left_j1', 25.0)
    both.temperature_reading('right_j1', 60.0)
    assert both.temperature[1] == 25.0 and both.temperature_names == (['left_j1'], ['right_j1'])
    second = behind('right_', stream[1])
    for m in (second, behind('left_', stream[2])):
        both.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
    both.temperature_reading('right_j2', 60.0)
    assert np.isnan(both.temperature[2])


def test_temperatures_of_an_arm_that_went_silent_are_none_of_the_next():
    arm, readings = ArmNames(JOINTS), JointTemperatures(JOINTS)
    assert arm.index(LEFT, 0.0) is not None
    readings.expire(0.0, arm)
    for name in LEFT:
        readings.take(name, 60.0, arm)
    assert arm.index(RIGHT, SILENT + 1.0) is not None
    # What comes at once, before time goes on, is the new arm's.
    readings.take(RIGHT[1], 20.0, arm)
    readings.expire(SILENT + 1.0, arm)
    assert np.isnan(readings.values[0]) and readings.values[1] == 20.0


def test_a_recording_of_two_arms_alike_is_refused(model, stream):
    both = [behind(side, changed(m, stamp=m.stamp + 1e-3 * (side == 'right_')))
            for m in stream[:50] for side in ('left_', 'right_')]
    joined = [changed(m, names=(*behind('left_', m).names, *behind('right_', m).names),
                      **{k: np.tile(vars(m)[k], 2) for k in ('position', 'velocity', 'effort')})
              for m in stream[:50]]
    for samples in (both, joined):
        recording = SimpleNamespace(path='bag', samples=samples)
        for use in (lambda: motion_of(model.robot, recording),
                    lambda: estimate_recording(warm(pipeline_of(model)), recording)):
            with pytest.raises(RecordingError, match="bag: .*'left_', 'right_'"):
                use()
