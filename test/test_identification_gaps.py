"""Recordings with gaps, and joints whose temperature nobody measured."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest
from test_identification import Made, NAMES

from hand_load_estimator.effects import NEEDS_TEMPERATURE
from hand_load_estimator.identification.evidence import between_gaps, prepare
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.identification.mixed_temperatures import mixed_temperatures
from hand_load_estimator.load import LoadParameters


@pytest.fixture(scope='module')
def made():
    return Made(four_axes())


def test_a_joint_without_a_sensor_has_no_effect_of_temperature(made):
    """What no data tell would keep its prior, and be the largest of the model's doubts."""
    blind = [replace(e, motion=replace(e.motion, temperature=np.where(
        np.arange(4) == 1, np.nan, e.motion.temperature))) for e in made.evidence]
    model = identify(made.robot, blind)
    of_warmth = {(u.name, u.joint) for u in model.uses if u.name in NEEDS_TEMPERATURE}
    assert {joint for _, joint in of_warmth} == {0, 2, 3}
    slopes = {use.joint: model.covariance[where.stop - 1, where.stop - 1]
              for use, where in model.slices() if use.name == 'stribeck_friction'}
    assert slopes[1] == 0.0 and min(slopes[0], slopes[2], slopes[3]) > 0.0
    assert model.temperatures is not None


def test_a_recording_without_the_temperatures_that_others_have_is_told(made):
    first, second = made.evidence[:2]
    blind = replace(second, motion=replace(second.motion, temperature=np.where(
        np.arange(4) == 1, np.nan, second.motion.temperature)))
    (said,) = mixed_temperatures(made.robot, [first, blind])
    assert said.startswith(
        f'WARNING: {second.name} holds no temperature of {made.robot.joints[1]}')
    assert not mixed_temperatures(made.robot, [first, second])
    assert not mixed_temperatures(made.robot, [blind, blind])


def test_motion_is_cut_where_joint_states_are_missing(made):
    """A delay reads the torque of a moment ago: across a gap there is none."""
    whole = made.evidence[0]
    motion = whole.motion
    later = replace(motion, stamp=motion.stamp + 0.5 * (np.arange(len(motion.stamp)) >= 900))
    parts = between_gaps([replace(whole, motion=later), whole])
    assert [len(p.torque) for p in parts] == [900, len(whole.torque) - 900, len(whole.torque)]
    assert parts[0].mark == parts[1].mark == whole.mark and parts[2] is whole
    model = identify(made.robot, [replace(made.evidence[0], motion=later), *made.evidence[1:]],
                     list(NAMES))
    assert model.recordings == tuple(e.mark for e in made.evidence)


def test_a_temperature_that_stops_coming_stays_as_it_was(made):
    """A reading is good for half a minute; then friction counted as of another temperature."""
    evidence = made.evidence[0]
    stamp = evidence.motion.stamp
    warming = 30.0 + 0.1 * (stamp - stamp[0])[:, None] * np.ones(4)
    warming[:, 1] = np.nan
    rows = np.arange(len(stamp))
    stopped = warming.copy()
    stopped[(rows > 100) & (rows < 200) | (rows > len(rows) - 50), 2] = np.nan
    motion = replace(evidence.motion, temperature=stopped)
    told = prepare(made.robot, 'run', motion, LoadParameters()).motion.temperature
    np.testing.assert_array_equal(told[:, [0, 1, 3]], warming[:, [0, 1, 3]])
    np.testing.assert_allclose(told[:-49, 2], warming[:-49, 2])
    assert (told[-49:, 2] == told[-50, 2]).all()
