"""
What misreads weights: a base that leans, and gains of the efforts, as uncertain directions.

Both may happen to an arm after its identification, and both act through the weight of arm and
load: taken for a load they stay in an estimate for ever, where friction averages out. They are
hardly doubted at first, so that they cost an arm that has neither next to nothing; heavy tails
(model_trust.py) find them where they are there.
"""

import numpy as np

# Standard deviation [rad] of gravity's direction about each tilt axis, as a bolted base holds it.
LEAN = 5e-4
# And of each joint's gain [-]. At 5e-4 intervals of a healthy arm are half as wide again after
# ten seconds of motion, and gains ten times as large are not found sooner.
GAIN = 2e-4


def misread_directions(n):
    """Return how many directions n joints have."""
    return 2 + n


def misread_columns(model, q, torque, carried):
    """
    Return (n, 2 + n) [Nm]: torque of the unit-variance directions.

    model: TorqueModel; q (n,) [rad]; torque (n,) [Nm]: all that drives give, as model and load
    have it; carried: products (10,) of what is held.
    """
    robot = model.robot
    links = model.mean[:10 * robot.n].copy()
    # The load is fixed to the last link.
    links[-10:] += robot.in_last_link(carried)
    lean = LEAN * robot.tilt_regressor(q, links, model.layout.tilt(model.mean))
    return np.hstack([lean, np.diag(GAIN * torque)])
