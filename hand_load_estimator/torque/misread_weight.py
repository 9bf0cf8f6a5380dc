"""
What misreads weights, as uncertain directions: a base that leans, gains of the efforts, and
friction that grows with the torque of the gears.

All may happen to an arm after its identification, and act through the weight of arm and load:
taken for a load they stay in an estimate for ever, where other friction averages out. They are
hardly doubted at first, so that an arm that has none of them pays next to nothing (mass intervals
7 % wider after ten seconds of motion); heavy tails (model_trust.py) find them where they are.
"""

import numpy as np

# Standard deviation [rad] of gravity's direction about each tilt axis. Five times as much finds a
# lean two seconds sooner, and costs a healthy arm a tenth of its accuracy.
LEAN = 1e-4
# And of each joint's gain [-].
GAIN = 1e-4
# And of what friction takes of the torque of each joint's gear [-].
TOOTH_FRICTION = 2e-4


def misread_directions(n):
    """Return how many directions n joints have."""
    return 2 + 2 * n


def misread_columns(model, q, z, gear, torque, carried):
    """
    Return (n, misread_directions(n)) [Nm]: torque of the unit-variance directions.

    Leans (2), gains (n), friction (n), in this order.

    model: TorqueModel; q (n,) [rad]; z (n,) in [-1, 1]: friction's state; gear, torque (n,) [Nm]:
    what the gears carry and all that drives give, as model and load have it; carried: products
    (10,) of what is held.
    """
    robot = model.robot
    links = model.mean[:10 * robot.n].copy()
    # The load is fixed to the last link.
    links[-10:] += robot.in_last_link(carried)
    out, joints = np.zeros((robot.n, misread_directions(robot.n))), np.arange(robot.n)
    out[:, :2] = LEAN * robot.tilt_regressor(q, links, model.layout.tilt(model.mean))
    out[joints, 2 + joints] = GAIN * torque
    out[joints, 2 + robot.n + joints] = TOOTH_FRICTION * np.abs(gear) * z
    return out
