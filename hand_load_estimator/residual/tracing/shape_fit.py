"""
Settle a shape between the values that a search tried: Gauss and Newton's steps in its logarithm.

A search by factors ends percents beside the best, where shapes that make up for one another leave
it no single factor that helps. The torque of a hypothesis made linear in its shapes tells how all
of them, and its own parameters beside them, are off at once.
"""

import numpy as np

from .hypotheses import reshaped
from .hypothesis import searched

TURNS = 8
# [-] in the logarithm, of the differences that tell what a shape does: far from the best a narrow
# one sees no more than the steps in which an impact is followed.
HALF_WIDTHS = (0.02, 0.08)
DOUBT, STEP = 0.3, 0.25  # [-] how far a shape may be off; how far it goes in one turn
# Of a ripple all of these are so many radians of its phase at the ends of the motion.
PHASE = 5.0
SHARES = (1.0, 0.5, 0.2)
LEAST = 0.5             # [nats] another turn must gain


def settled(hypothesis, score, blocks, model, residual, rank):
    """
    Return (Hypothesis, Score on Blocks) with the shape where it fits best, number of trials.

    rank(hypothesis, score): what the better of two has more of, with nats for its last.
    """
    best, count = (hypothesis, score), 0
    for _ in range(TURNS if searched(hypothesis) else 0):
        factors = [tuple(np.exp(share * step).tolist())
                   for step in _steps(*best, blocks, model, residual) for share in SHARES]
        tried = [(trial, blocks.evaluate(trial.columns))
                 for trial in reshaped(best[0], factors, model, residual)]
        count += len(tried)
        before, best = best, max([best, *tried], key=lambda pair: rank(*pair))
        if best[1].gain < before[1].gain + LEAST:
            break
    return best, count


def _steps(hypothesis, score, blocks, model, residual):
    """Return how far (k,) the logarithms of the shapes are off, as each of HALF_WIDTHS tells."""
    size, unit = len(searched(hypothesis)), _unit(hypothesis, residual)
    widths = unit * np.concatenate([width * np.eye(size) for width in HALF_WIDTHS])
    factors = [tuple(row) for row in np.exp(np.concatenate([widths, -widths]))]
    moved = reshaped(hypothesis, factors, model, residual)
    pairs, steps = list(zip(moved[:len(widths)], moved[len(widths):])), []
    for k, width in enumerate(HALF_WIDTHS):
        both = {}
        for j, columns in hypothesis.columns.items():
            slopes = [(up.columns[j] - down.columns[j]) @ score.theta * (0.5 * DOUBT / width)
                      for up, down in pairs[size * k:size * k + size]]
            both[j] = np.column_stack([columns, *slopes])
        steps.append(unit * np.clip(DOUBT * blocks.evaluate(both).theta[-size:], -STEP, STEP))
    return steps


def _unit(hypothesis, residual):
    """Return what a step of one is in the logarithm of the shapes."""
    if 'periods' not in hypothesis.shape:
        return 1.0
    reach = 0.5 * np.ptp(residual.x.q[:, hypothesis.joint])
    return PHASE / (hypothesis.shape['periods'] * reach)
