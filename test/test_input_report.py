"""/diagnostics on the input: temperatures that are missing, and those of nobody, are told."""

from core_helpers import EFFECTS, block, exact_model, messages, pipeline_of
import pytest

from hand_load_estimator.nodes.diagnostics import ERROR, OK, STALE, WARN
from hand_load_estimator.nodes.input_report import InputReport

COLD = tuple(name for name in EFFECTS if not name.startswith('temperature'))


class Fed:
    """An InputReport and its pipeline, fed second by second as by a robot that stands."""

    def __init__(self, names=EFFECTS):
        model = exact_model('four', names)
        self._pipeline, self._report = pipeline_of(model), InputReport()
        self._joints, self._still, self._now = model.robot.joints, messages(
            model, block(1.0), 0.1)[0], 0.0

    def feed(self, names=None, effort=None):
        """Feed fifty joint states; those of other names come beside the arm's, at its times."""
        m = self._still
        for k in range(50):
            self._now += 0.02 if names is None else 0.0
            self._report.joint_state()
            self._pipeline.joint_state(self._now, m.names if names is None else names,
                                       m.position, m.velocity,
                                       m.effort + 1e-6 * k if effort is None else effort)

    def second(self, temperatures=(), effort=None, names=None):
        """Feed fifty joint states and temperatures {name: degC}; return what is said of them."""
        self.feed(names, effort)
        for name, celsius in dict(temperatures).items():
            self._report.temperature(name, self._joints)
            self._pipeline.temperature_reading(name, celsius)
        return self.said()

    def said(self):
        """Return level, message and values without new input."""
        return self._report.report(self._pipeline)


ALL = dict.fromkeys(('j0', 'j1', 'j2', 'j3'), 30.0)


def test_all_temperatures_known_is_well():
    fed = Fed()
    for _ in range(2):
        level, message, values = fed.second({'left_j0': 31.0, **ALL})
    assert (level, message) == (OK, 'joint states arrive')
    assert values['temperatures known'] == '4 of 4' and values['received temperatures'] == 10


def test_missing_temperatures_are_told_with_their_joints():
    fed = Fed()
    assert fed.second({'j0': 30.0, 'j2': 30.0})[0] == OK, 'they may still come'
    level, message, values = fed.second()
    assert (level, message) == (
        WARN, 'no temperature of j1, j3: taken as unknown, intervals wider')
    assert values['temperatures known'] == '2 of 4'
    assert fed.second(ALL)[0] == OK


def test_names_of_no_joint_are_told_and_not_rejected():
    """A driver once sent joint_0 to joint_5, and all was said to be well."""
    fed = Fed()
    for _ in range(2):
        level, message, values = fed.second({'joint_0': 30.0, 'joint_1': 30.0})
    assert level == WARN and message.startswith('no temperature of j0, j1, j2, j3')
    assert "temperatures arrive of 'joint_0', 'joint_1': frame_id must be the name" in message
    assert values["temperatures of 'joint_0', no joint of this robot"] == 2
    assert not any(key.startswith('rejected') for key in values)


def test_a_gripper_beside_a_whole_arm_is_well():
    fed = Fed()
    for _ in range(2):
        level, _, values = fed.second({'finger': 30.0, **ALL})
    assert level == OK and values["temperatures of 'finger', no joint of this robot"] == 2


def test_endless_names_do_not_fill_the_diagnostics():
    values = Fed().second({f'joint_{k}': 30.0 for k in range(10, 1000)})[2]
    assert 5 < sum(key.endswith('no joint of this robot') for key in values) < 20


def test_an_arm_without_sensors_is_not_asked_for_temperatures():
    """Its model has no temperature effect: a warning for ever would only teach to overlook it."""
    fed = Fed(COLD)
    for _ in range(3):
        level, message, values = fed.second()
    assert (level, message) == (OK, 'joint states arrive')
    assert values['temperatures known'] == '0 of 4'


def test_zero_for_no_temperature_is_told_as_none_and_hides_nothing():
    zero = dict.fromkeys(ALL, 0.0)
    fed = Fed(COLD)
    for _ in range(2):
        level, message, values = fed.second(zero)
    assert (level, message) == (OK, 'joint states arrive')
    assert values['rejected zero_temperature'] == 8
    fed = Fed()
    for _ in range(2):
        _, message, _ = fed.second(zero)
    assert message == 'no temperature of j0, j1, j2, j3: taken as unknown, intervals wider'
    assert 'no usable joint state' in fed.second(zero, names=('j0', 'j1', 'j2', 'x'))[1]


def test_a_sensor_that_falls_silent_is_told():
    fed = Fed()
    fed.second(ALL)
    for _ in range(31):
        level, message, _ = fed.second({'j0': 30.0, 'j1': 30.0, 'j3': 30.0})
    assert level == WARN and 'no temperature of j2:' in message


def test_two_complaints_are_both_told():
    fed = Fed()
    fed.second()
    level, message, _ = fed.second(effort=(float('nan'),) * 4)
    assert level == WARN and message.startswith('50 inputs rejected in the last second; no temp')


OTHERS = ('lwr_0', 'lwr_1', 'lwr_2', 'lwr_3')
SOME = ('j0', 'j1', 'j2', 'lwr_3')


@pytest.mark.parametrize('names, reason', [
    (OTHERS, 'joint states name lwr_0, lwr_1, lwr_2, lwr_3, but none of j0, j1, j2, j3'),
    (SOME, 'joint states name j0, j1, j2, lwr_3, but never all of j0, j1, j2, j3')])
def test_joint_states_of_another_arm_are_told_with_both_names(names, reason):
    """500 of them a second were called joint states that arrive."""
    fed = Fed(COLD)
    for _ in range(2):
        level, message, values = fed.second(names=names)
    assert (level, message) == (WARN, reason)
    assert values['joint_states of no joint of this robot'] == (100 if names is OTHERS else 0)


def test_joint_states_of_others_beside_the_arms_are_counted_and_well():
    fed = Fed(COLD)
    for _ in range(2):
        for names in (OTHERS, SOME):
            fed.feed(names)
        level, message, values = fed.second()
    assert (level, message) == (OK, 'joint states arrive')
    assert values['joint_states of no joint of this robot'] == 100
    assert values['rejected missing_joint'] == 100


def test_an_arm_that_falls_silent_beside_others_is_told():
    fed = Fed(COLD)
    assert fed.second()[0] == OK
    for _ in range(2):
        level, message, _ = fed.second(names=OTHERS)
        assert level == WARN and message.startswith('no usable joint state in the last second')
    assert fed.second()[0] == OK


@pytest.mark.parametrize('seconds, level', [(0, ERROR), (1, STALE)])
def test_silence_comes_first(seconds, level):
    fed = Fed()
    for _ in range(seconds):
        fed.second()
    assert fed.said()[0] == level


def test_temperatures_of_two_arms_that_nobody_can_tell_apart_are_told():
    fed, hot = Fed(), {f'right_{joint}': 60.0 for joint in ALL}
    cool = {f'left_{joint}': 25.0 for joint in ALL}
    for _ in range(2):
        level, message, values = fed.second(hot | cool)
    assert level == WARN and 'temperatures of more arms than one' in message
    assert 'right_j0' in values['temperatures are taken from']
    assert fed.second(ALL)[:2] == (OK, 'joint states arrive')
