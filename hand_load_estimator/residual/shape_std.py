"""How well a searched shape is known: from the curvature of what it gains, around its value."""

from itertools import combinations

import numpy as np

from .hypotheses import reshaped

# A step in the logarithm of a shape is to cost NEAR to FAR nats, best GOOD of them: few enough
# for a parabola, many enough to be no accident. It begins with FIRST, is changed by no more than
# these factors, TURNS times at most, and never wider than WIDEST.
NEAR, GOOD, FAR = 0.5, 2.0, 8.0
FIRST, WIDEST, FACTORS, TURNS = 0.06, 0.5, (0.01, 4.0), 8
LEAST = 1e-3   # [nats] a direction of curvature costs at least, for one such step


def shape_std(hypothesis, blocks, model, residual):
    """
    Return {name: standard deviation} of a Hypothesis' shape, in the shape's units.

    blocks: Blocks with everything else that was found; the effect's own parameters are fitted
    again for every trial. NaN where the gain has no curvature of a maximum.
    """
    names = list(hypothesis.shape)

    def gains(steps):
        return np.array([blocks.evaluate(trial.columns).by_block for trial in reshaped(
            hypothesis, [tuple(factors) for factors in np.exp(steps)], model, residual)])
    here = gains(np.zeros((1, len(names)))).sum()
    found = [_step(gains, here, axis) for axis in np.eye(len(names))]
    widths = np.array([width for width, _, _ in found])
    cost = np.diag([2.0 * fall for _, fall, _ in found])
    for i, j in combinations(range(len(names)), 2):
        signs = np.zeros((4, len(names)))
        signs[:, [i, j]] = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
        cost[i, j] = cost[j, i] = -gains(signs * widths).sum(axis=1) @ [1.0, 1.0, -1.0, -1.0] / 4.0
    std = _std(cost, np.array([slope for _, _, slope in found]))
    return {name: abs(hypothesis.shape[name]) * part for name, part in zip(names, widths * std)}


def _step(gains, here, axis):
    """Return width of a step along an axis, nats it costs on average, slope by block (B,)."""
    width = FIRST
    for turn in range(TURNS):
        up, down = gains(width * np.stack([axis, -axis]))
        fall = here - 0.5 * (up + down).sum()
        if NEAR < fall < FAR or fall < NEAR and width == WIDEST or turn == TURNS - 1:
            return width, fall, 0.5 * (up - down)
        width = min(width * np.clip(np.sqrt(GOOD / max(fall, 1e-9)), *FACTORS), WIDEST)


def _std(cost, slopes):
    """
    Return standard deviations (k,) in steps, NaN where nothing is told.

    cost (k, k): half of x^T cost x nats are lost x steps away; slopes (k, B) [nats] by block.
    """
    kept, out = list(range(len(cost))), np.full(len(cost), np.nan)
    while kept:
        part = cost[np.ix_(kept, kept)]
        if np.linalg.eigvalsh(part).min() > LEAST:
            inverse = np.linalg.inv(part)
            # Blocks that do not agree tell less than their noise says (White 1982); and a search
            # ends a little beside the best.
            spread = inverse @ slopes[kept]
            by_block = spread.shape[1] * spread.var(axis=1)
            out[kept] = np.sqrt(np.maximum(np.diag(inverse), by_block) + spread.sum(axis=1) ** 2)
            break
        # What has no maximum has no interval, and must not widen those of the others.
        kept.remove(min(kept, key=lambda k: cost[k, k]))
    return out
