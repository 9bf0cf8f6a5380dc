"""
The regressor of the links as the motion filter shows it.

The torque passes the filter F (motion.py), and so does every torque that the arm makes: what is
seen is F[Y], where Y at the filtered motion is something else, because Y bends with it. Gravity is
the plainest case: while a joint turns, the mean of its cosine is less than the cosine of its mean
angle, and a load at rest in the filter's eye weighs more than one that passes by. To second order
in what the arm does within the filter, F[Y(x)] = Y + s^2 Y''[x', x'] / 2 for a filter whose
impulse response has the standard deviation s: the mean of Y at x + s x' and x - s x'. Messages
further apart than 10 ms are joined by straight lines, which spread a motion as well: less of the
error is made up for then, a third of it at 20 Hz.
"""

import numpy as np

from ..motion import BANDWIDTH

# Of the impulse response [s]: three stages of 1 / w each.
SPREAD = np.sqrt(3.0) / BANDWIDTH


def shown_links(robot, motion):
    """
    Return F[Y] (N, n, 10 n) of a Robot along a Motion or an EffectInput.

    Without a jerk the motion went through no filter, and the same is Y.
    """
    return shown_links_and_way(robot, motion)[0]


def shown_links_and_way(robot, motion):
    """Return F[Y] and how far Y goes either way within the filter: s Y', (N, n, 10 n) each."""
    state = np.array((motion.q, motion.v, motion.a))
    if motion.jerk is None:
        links = _links_along(robot, state)
        return links, np.zeros_like(links)
    way = SPREAD * np.array((motion.v, motion.a, motion.jerk))
    after, before = _links_along(robot, state + way), _links_along(robot, state - way)
    return 0.5 * (after + before), 0.5 * (after - before)


def _links_along(robot, state):
    """Return Y (N, n, 10 n) at states q, v, a (3, N, n)."""
    return np.array([robot.link_regressor(*row) for row in zip(*state)])
