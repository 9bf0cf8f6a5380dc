"""`hand_load check` on stamps, repeated states and joint temperatures."""

from dataclasses import replace

from check_helpers import only, recording, swings, torque, verdicts
import numpy as np
import pytest

from hand_load_estimator.checks.motion import check_updates
from hand_load_estimator.checks.recording_check import check_recording
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.recording import TemperatureSample
from hand_load_estimator.robot import load_robot


@pytest.fixture(scope='module')
def robot():
    return load_robot(find_shared('ur10e', 'robots'))


@pytest.fixture(scope='module')
def motion():
    return swings()


@pytest.mark.parametrize('temperature, item', [
    (303.0, 'temperature unit'), (np.nan, 'temperature unit'),
    (120.0, 'temperature unit')])
def test_implausible_temperatures(robot, motion, temperature, item):
    made = recording(robot, motion, torque(robot, motion), temperature=temperature)
    only(verdicts(robot, made), **{item.replace(' ', '_'): 'wrong'})


@pytest.mark.parametrize('joint, temperature, verdict', [
    (2, lambda t: 0.0, 'wrong'), (2, lambda t: 30.0 * (t > 5.0), 'wrong'),
    (None, lambda t: (4.0 + t) * (round(10.0 * t) % 10 != 5), 'wrong'),
    (None, lambda t: 0.0, 'doubt'), (None, lambda t: np.rint(0.5 * t - 3.0), 'ok')])
def test_a_zero_is_missing_where_none_is_near(robot, motion, joint, temperature, verdict):
    """A hall at 0 degC is no missing sensor."""
    made = recording(robot, motion, torque(robot, motion))
    chosen = [robot.joints[joint]] if joint is not None else robot.joints
    made = replace(made, samples=[
        replace(s, value=float(temperature(s.stamp)))
        if isinstance(s, TemperatureSample) and s.joint in chosen else s for s in made.samples])
    assert verdicts(robot, made)['temperature unit'] == verdict


def test_fahrenheit_and_none_are_doubts(robot, motion):
    effort = torque(robot, motion)
    only(verdicts(robot, recording(robot, motion, effort, temperature=86.0)),
         temperature_unit='doubt')
    only(verdicts(robot, recording(robot, motion, effort, temperature=None)),
         temperatures='doubt')


@pytest.mark.parametrize('joints', [slice(None), slice(2, 3)])
def test_efforts_too_large_for_any_unit_are_none(robot, motion, joints):
    """Their squares are infinite, and what was made of them ended in a traceback."""
    effort = torque(robot, motion)
    effort[:, joints] = 1e300
    assert verdicts(robot, recording(robot, motion, effort))['values'] == 'wrong'
    few = torque(robot, motion)
    few[1000, joints] = 1e300
    only(verdicts(robot, recording(robot, motion, few)), values='doubt')


def test_gaps_and_stamps(robot, motion):
    t, q, v, a = motion
    effort, late = torque(robot, motion), t.copy()
    late[1000:] += 0.7
    assert verdicts(robot, recording(robot, (late, q, v, a), effort))['gaps'] == 'doubt'
    back = t.copy()
    back[500], back[700] = back[498], back[699]
    assert verdicts(robot, recording(robot, (back, q, v, a), effort))['order'] == 'doubt'
    same = np.zeros_like(t)
    for stamps, words in ((same, 'all header stamps are the same'),
                          (-t, '0 repeated, 2399 backward stamps of 2400')):
        check = check_recording(recording(robot, (stamps, q, v, a), effort), robot)
        rate, = [f for f in check.findings if f.item == 'rate']
        assert rate.verdict == 'wrong' and words in rate.text


def test_one_stamp_far_ahead_costs_one_message(robot, motion):
    t, q, v, a = motion
    ahead = t.copy()
    ahead[300] += 3600.0
    check = check_recording(recording(robot, (ahead, q, v, a), torque(robot, motion)), robot)
    whole = check_recording(recording(robot, motion, torque(robot, motion)), robot)
    for joint, row in check.joints.items():
        assert row['gain'] == pytest.approx(whole.joints[joint]['gain'], abs=0.02)


def test_repeated_states(robot, motion):
    hold = np.arange(len(motion[0])) // 2 * 2
    twice = tuple(x[hold] for x in motion[1:])
    made = recording(robot, (motion[0], *twice), torque(robot, motion)[hold])
    assert verdicts(robot, made)['updates'] == 'doubt'


@pytest.mark.parametrize('times, share', [(1, '0.0 %'), (2, '50 %'), (4, '75 %')])
def test_repeats_are_a_share_of_all_messages_in_motion(times, share):
    """Of every second one it was said to be all of them, of three in four that there is none."""
    place = np.repeat(np.cumsum(np.full((500, 2), 1e-3), axis=0), times, axis=0)
    rest = np.repeat(place[-1:], 400, axis=0)
    found = check_updates(*[np.concatenate([place, rest])] * 3)
    assert float(found.text.split()[0]) == pytest.approx(float(share.split()[0]), abs=1.0)
    assert found.verdict == ('ok' if times == 1 else 'doubt')


def test_two_arms_alike_on_one_topic(robot, motion):
    made = recording(robot, motion, torque(robot, motion))
    own = [s if isinstance(s, TemperatureSample) else replace(
        s, names=tuple(f'{"left_" if k % 2 else "right_"}{name}' for name in s.names))
        for k, s in enumerate(made.samples)]
    found = {f.item: f for f in check_recording(replace(made, samples=own), robot).findings}
    assert found['joints'].verdict == 'wrong' and 'more arms than one' in found['joints'].text
