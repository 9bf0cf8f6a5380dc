"""
Find the delay of a joint that does other things too: its torque comes late, theirs with it.

Beside the others as they are without a delay, another delay fits best, or none.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from ...effects.time_delay import LATEST
from .finer_shape import SAME
from .hypotheses import of_shapes
from .hypothesis import beside_delays, whole

# Of the delay found without the others; a ripple's phase comes back within that.
FACTORS = np.geomspace(0.4, 2.5, 15)
# Where the best stands at an end, the search goes on from there, so many times in all.
FURTHER = 3
# [-] of the logarithm of the delay, when it is near enough.
CLOSE = 2e-3


def delayed(residual, hypothesis):
    """Return the Residual of joints whose torque comes later by what a Hypothesis says."""
    return replace(residual, delays={**residual.delays, **{
        j: residual.declared.get(j, 0.0) + hypothesis.shape['shift'] for j in hypothesis.columns}})


def delay_among(hypothesis, others, blocks, model, residual):
    """
    Return the Hypothesis of a delay where it and others of its joints fit best together.

    others: their Hypotheses; blocks: Blocks with neither of them.
    """
    def tried(shift):
        shift = min(float(shift), LATEST)
        (moved,) = of_shapes(hypothesis, [{'shift': shift}], model, residual)
        return moved, *_together(moved, others, blocks, delayed(residual, moved))

    start = hypothesis.shape['shift']
    for _ in range(FURTHER):
        shifts = start * FACTORS
        found = [tried(shift) for shift in shifts]
        at = max(range(len(found)), key=lambda k: found[k][1:3])
        start = shifts[at]
        if 0 < at < len(shifts) - 1:
            break
    about = np.log(shifts[[max(at - 1, 0), min(at + 1, len(shifts) - 1)]])
    best = minimize_scalar(lambda log: -tried(np.exp(log))[2], bounds=about, method='bounded',
                           options={'xatol': CLOSE})
    finer = max(found[at], tried(np.exp(best.x)), key=lambda those: those[1:3])
    # Of a short delay only its product with the share shows.
    exact = tried(finer[0].shape['shift'] * finer[3]) if finer[3] > 0.0 else finer
    return exact[0] if exact[1] and exact[2] > finer[2] - SAME else finer[0]


def _together(delay, others, blocks, residual):
    """Return (is the share a whole, nats gained, share) of a delay and what it delays."""
    gain, shares, doubts = 0.0, [], []
    for j, own in delay.columns.items():
        beside = [beside_delays(other.at(j), residual).columns[j] for other in others
                  if j in other.columns]
        score = blocks.evaluate({j: np.hstack([own, *beside])})
        gain += score.gain
        shares.append(score.theta[0] * delay.scale[0])
        doubts.append(np.sqrt(score.covariance[0, 0]) * delay.scale[0])
    weights = np.reciprocal(np.square(doubts))
    share = float(np.average(shares, weights=weights))
    return whole(share, weights.sum() ** -0.5), gain, share
