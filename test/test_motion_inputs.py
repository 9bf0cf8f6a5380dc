"""What the columns read along motions: in many ways of turning at once, and computed once."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
from test_effects_online import filtered

from hand_load_estimator.motion import Motion
from hand_load_estimator.torque.columns import ColumnLayout, torque_columns
from hand_load_estimator.torque.motion_inputs import known_motion, motion_input, motion_inputs
from hand_load_estimator.torque.shown_along import WAYS
from hand_load_estimator.torque.shown_links import shown_links_and_way


def test_ways_of_turning_side_by_side_are_as_each_alone():
    robot = four_axes()
    motions = [Motion.of(filtered(seconds, 125.0)) for seconds in (3.0, 1.2)]
    ways = [(np.full(4, travel), np.full(4, plastic)) for travel in (3e-4, 6e-4, 1e-3, 2e-3, 4e-3)
            for plastic in (2.0, 0.5, 0.8)]
    assert len(ways) > WAYS
    several = list(motion_inputs(robot, motions, ways, None))
    assert len(several) == len(ways)
    for found, own in zip(several, ways):
        for motion, (x, doubt) in zip(motions, found):
            alone, doubted = motion_input(robot, replace(motion), *own)
            np.testing.assert_array_equal(x.z, alone.z)
            np.testing.assert_array_equal(doubt, doubted)
            np.testing.assert_array_equal(x.shown(1, 2e-3, 2.0), alone.shown(1, 2e-3, 2.0))
    assert np.abs(several[0][0][0].z - several[-1][0][0].z).max() > 0.1


def test_what_a_motion_knows_is_of_its_robot_and_of_it_alone():
    robot, motion = four_axes(), Motion.of(filtered(2.0, 125.0))
    known = known_motion(robot, motion)
    assert known_motion(robot, motion) is known
    assert known_motion(four_axes(), motion) is not known
    faster = replace(motion, v=1.1 * motion.v, a=1.1 * motion.a)
    x, _ = motion_input(robot, faster, np.full(4, 1e-3))
    layout, found = ColumnLayout(4, ()), known_motion(robot, faster).links
    np.testing.assert_array_equal(torque_columns(robot, layout, x, links=found),
                                  torque_columns(robot, layout, x))
    assert np.abs(found[0] - known.links[0]).max() > 1e-3
    np.testing.assert_array_equal(known.links[0], shown_links_and_way(robot, motion)[0])
