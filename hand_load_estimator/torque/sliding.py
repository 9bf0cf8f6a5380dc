"""Rows at which joints surely slide, and the residual there, averaged as the watch does online."""

import numpy as np

# A joint slides when it is this fast [rad/s] and its friction has turned all the way, surely.
SLIDING_SPEED, TURNED, DOUBT = 0.03, 0.98, 0.05
# Length of a block, one of those the density was read from, and the least of it that counts
# [s of motion]. Longer ones lose ripple, and friction where a joint turns around.
BLOCK, LEAST = 0.2, 0.1
# With less motion than this [s] a joint's residual and friction are not known.
FEWEST_SECONDS = 2.0


def surely_slides(v, z, doubt):
    """Tell where joints slide; v [rad/s], friction state z and its doubt, of any shape."""
    return (np.abs(v) > SLIDING_SPEED) & (doubt < DOUBT) & (np.abs(z) > TURNED)


def moved_joints(evidence):
    """Tell which joints (n,) a list of Evidence shows in motion for FEWEST_SECONDS."""
    return sum(e.motion.dt @ (e.tells & (np.abs(e.motion.v) > SLIDING_SPEED))
               for e in evidence) >= FEWEST_SECONDS


def sliding_rms(residual, sliding, dt, owner):
    """
    Return the RMS (n,) [Nm] of a residual's means over blocks of motion, NaN with too little.

    residual (N, n) [Nm]; sliding (N, n) bool; dt (N,) [s]; owner (N,): recording of each row.
    """
    rows = sliding.any(axis=1)
    residual, sliding, dt, owner = residual[rows], sliding[rows], dt[rows], owner[rows]
    # Blocks as the watch cuts them; a recording's end ends one.
    number = np.floor((np.cumsum(dt) - dt) / BLOCK + 1e-6) \
        + np.cumsum(np.diff(owner, prepend=0) != 0)
    starts = np.flatnonzero(np.diff(number, prepend=-1.0))
    if not len(starts):
        return np.full(sliding.shape[1], np.nan)
    each = sliding * dt[:, None]
    seconds = np.add.reduceat(each, starts)
    means = np.add.reduceat(each * residual, starts) / np.maximum(seconds, 1e-9)
    counted = np.where(seconds >= LEAST, seconds, 0.0)
    total = counted.sum(axis=0)
    square = (counted * means ** 2).sum(axis=0) / np.maximum(total, 1e-9)
    return np.sqrt(np.where(total >= FEWEST_SECONDS, square, np.nan))
