"""The limits that hold wherever in the cycle the rated load has to be counted on."""

import numpy as np

from .load_belief import rated_belief
from .planned_move import MotionLimits

_SAME = 1e-3  # [rad] nearer waypoints are one


def rated_cycle_limits(planner, robot, waypoints, speed_scale):
    """
    Return the smallest MotionLimits among the cycle's moves with the rated load (E8.3).

    planner: MovePlanner; waypoints: name -> (n,) [rad] for home, pick and place. Temperatures
    are taken as unknown.
    """
    limits, belief = robot.limits, rated_belief(robot)
    found = [MotionLimits(speed_scale * limits.velocity, limits.acceleration,
                          limits.acceleration)]
    for start, goal in (('home', 'pick'), ('pick', 'place'), ('place', 'home')):
        start, goal = np.asarray(waypoints[start]), np.asarray(waypoints[goal])
        if np.max(np.abs(goal - start)) > _SAME:
            move = planner.plan(start, goal, belief, np.full(robot.n, np.nan))
            found.append(move.motion_limits(limits, speed_scale))
    return MotionLimits(*(np.min([getattr(each, name) for each in found], axis=0)
                          for name in ('velocity', 'acceleration', 'deceleration')))
