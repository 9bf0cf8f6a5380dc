"""
How well a searched shape is known: from the curvature of what it gains, around its value.

What is not known of a shape is not known of the effect's own parameters either: a peak's level
goes with the velocity at which it falls.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from .hypotheses import reshaped
from .hypothesis import searched

# A step in the logarithm of a shape is to cost NEAR to FAR nats, best GOOD of them: few enough
# for a parabola, many enough to be no accident. It begins with FIRST, is changed by no more than
# these factors, TURNS times at most, and never wider than WIDEST.
NEAR, GOOD, FAR = 0.5, 2.0, 8.0
FIRST, WIDEST, FACTORS, TURNS = 0.06, 0.5, (0.01, 4.0), 8
LEAST = 1e-3   # [nats] a direction of curvature costs at least, for one such step


@dataclass(frozen=True)
class ShapeDoubt:
    """
    What is not known of a Hypothesis' shape.

    std: {name: standard deviation} in the shape's units, NaN where the gain has no curvature of a
    maximum; of_parameters (k, k): covariance that this adds to that of the effect's own
    parameters, in theirs; nothing for what has no maximum. Of a declared effect with another form
    both are of what comes to it: a change of the same size stands for the whole.
    """

    std: dict
    of_parameters: np.ndarray


# Of what was not searched; a single zero stands for any number of parameters.
NO_DOUBT = ShapeDoubt({}, np.zeros((1, 1)))


def shape_doubt(hypothesis, blocks, model, residual):
    """
    Return the ShapeDoubt of a Hypothesis.

    blocks: Blocks with everything else that was found; the effect's own parameters are fitted
    again for every trial.
    """
    names = list(searched(hypothesis))
    if not names:
        return NO_DOUBT

    def scores(steps):
        return [blocks.evaluate(trial.columns) for trial in reshaped(
            hypothesis, [tuple(factors) for factors in np.exp(steps)], model, residual)]

    def gains(steps):
        return np.array([score.by_block for score in scores(steps)])
    here = gains(np.zeros((1, len(names)))).sum()
    widths, falls, slopes = _steps(gains, here, len(names))
    cost = np.diag(2.0 * falls)
    pairs = list(combinations(range(len(names)), 2))
    signs = np.zeros((len(pairs), 4, len(names)))
    for k, (i, j) in enumerate(pairs):
        signs[k][:, [i, j]] = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
    if pairs:
        # At once: gaps followed beside one another cost little more than one of them.
        mixed = gains((signs * widths).reshape(-1, len(names))).sum(axis=1).reshape(-1, 4)
        for (i, j), bend in zip(pairs, -mixed @ [1.0, 1.0, -1.0, -1.0] / 4.0):
            cost[i, j] = cost[j, i] = bend
    covariance = _covariance(cost, slopes)
    std = widths * np.sqrt(np.diag(covariance))
    up, down = (np.array([score.theta for score in scores(sign * np.diag(widths))])
                for sign in (1.0, -1.0))
    moved = 0.5 * (up - down) * hypothesis.scale
    return ShapeDoubt({name: abs(hypothesis.shape[name]) * part for name, part in zip(names, std)},
                      moved.T @ np.nan_to_num(covariance) @ moved)


def _steps(gains, here, size):
    """Return widths (k,) of a step along each axis, nats (k,) it costs, slopes (k, B) by block."""
    widths, falls, slopes = np.full(size, FIRST), np.zeros(size), [None] * size
    left = list(range(size))
    for turn in range(TURNS):
        axes = np.eye(size)[left] * widths[left, None]
        up, down = np.split(gains(np.concatenate([axes, -axes])), 2)
        for k, above, below in zip(tuple(left), up, down):
            falls[k], slopes[k] = here - 0.5 * (above + below).sum(), 0.5 * (above - below)
            if NEAR < falls[k] < FAR or falls[k] < NEAR and widths[k] == WIDEST:
                left.remove(k)
            elif turn < TURNS - 1:
                change = np.clip(np.sqrt(GOOD / max(falls[k], 1e-9)), *FACTORS)
                widths[k] = min(widths[k] * change, WIDEST)
        if not left:
            break
    return widths, falls, np.array(slopes)


def _covariance(cost, slopes):
    """
    Return the covariance (k, k) in steps, NaN where nothing is told.

    cost (k, k): half of x^T cost x nats are lost x steps away; slopes (k, B) [nats] by block.
    """
    kept, out = list(range(len(cost))), np.full(cost.shape, np.nan)
    while kept:
        part = cost[np.ix_(kept, kept)]
        if np.linalg.eigvalsh(part).min() > LEAST:
            inverse = np.linalg.inv(part)
            # Blocks that do not agree tell less than their noise says (White 1982); and a search
            # ends a little beside the best.
            spread = inverse @ slopes[kept]
            by_block = spread.shape[1] * spread.var(axis=1)
            variance = np.maximum(np.diag(inverse), by_block) + spread.sum(axis=1) ** 2
            wider = np.sqrt(variance / np.diag(inverse))
            out[np.ix_(kept, kept)] = wider[:, None] * inverse * wider
            break
        # What has no maximum has no interval, and must not widen those of the others.
        kept.remove(min(kept, key=lambda k: cost[k, k]))
    return out
