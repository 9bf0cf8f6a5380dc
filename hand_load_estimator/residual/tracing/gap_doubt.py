"""
How well a gap's figures are known: from many gaps drawn around it, weighed by what they gain.

A gap is followed in steps, and its gain is rough; a longer lag makes up for a shorter travel, and
more of the pose for more of it. No curvature at the best figures tells that. Draws do, weighed
as if so many nats were one: adaptive importance sampling (Bugallo et al. 2017), cooled down to
the height of those steps from a temperature at which enough of the draws count, or as far as they
do: intervals are wider then. What nothing tells stays as wide as before any gain.

How long a crossing takes tells the product of travel and inertia, and an impact returns what the
crossing spared whatever the inertia. So far as the pose does not show, that of the links at any
of the poses of the crossings may have crossed.
"""

import numpy as np

from .hypotheses import of_shapes
from .shape_doubt import ShapeDoubt

GAP, TRAVEL, POSE_SHARE = 'backlash', 'travel', 'pose_share'
# Where a crossing moves on by one step of play.py the gain changes by about so much of itself [-].
ROUGH = 5e-3
DRAWS, ROUNDS = 120, 12
# So many draws have to count, by their weights; before any gain a figure may be so far off, in its
# logarithm.
COUNT, FIRST = 24.0, 1.0
# The next draws are so much wider than what is told so far, and no narrower than this.
WIDER, LEAST = 1.3, 1e-12


def gap_doubt(hypothesis, blocks, model, residual):
    """Return the ShapeDoubt of a Hypothesis of a gap; arguments as of shape_doubt."""
    names = list(hypothesis.shape)
    plain = np.array([name == POSE_SHARE for name in names])
    found = np.array([hypothesis.shape[name] for name in names])
    draws, scores, weights = _cooled(hypothesis, plain, blocks, model, residual)
    mean, covariance = _moments(draws, weights)
    # About what was found, which is the best of them and seldom their mean.
    off = mean - np.where(plain, np.clip(found, 0.0, 1.0), np.log(found))
    std = np.sqrt(np.diag(covariance) + off ** 2) * np.where(plain, 1.0, found)
    told = dict(zip(names, std.tolist()))
    told[TRAVEL] = float(np.hypot(told[TRAVEL], (1.0 - mean[names.index(POSE_SHARE)])
                                  * hypothesis.shape[TRAVEL] * _off_usual(hypothesis, residual)))
    _, of_parameters = _moments(np.array([score.theta for score in scores]), weights)
    return ShapeDoubt(told, of_parameters * np.outer(hypothesis.scale, hypothesis.scale))


def _cooled(hypothesis, plain, blocks, model, residual):
    """
    Return draws (N, k) of a gap's figures, their Scores and weights (N,), cooled down.

    plain (k,): which figures are drawn as they are, between 0 and 1; of others the logarithm.
    """
    rng, names = np.random.default_rng(0), list(hypothesis.shape)
    start = np.where(plain, 0.5, np.log([hypothesis.shape[name] for name in names]))
    first = mean, covariance = start, np.diag(np.where(plain, 1.0, FIRST) ** 2)
    rough = max(ROUGH * blocks.evaluate(hypothesis.columns).by_block.sum(), 1.0)
    best, kept = np.inf, None
    for _ in range(ROUNDS):
        drawn = mean, WIDER ** 2 * covariance + LEAST * np.eye(len(names))
        draws = _within(rng, *drawn, plain)
        shapes = [dict(zip(names, np.where(plain, draw, np.exp(draw)).tolist()))
                  for draw in draws]
        scores = [blocks.evaluate(trial.columns)
                  for trial in of_shapes(hypothesis, shapes, model, residual)]
        gains = np.array([score.by_block.sum() for score in scores])
        expected = _log_density(draws, *first) - _log_density(draws, *drawn)
        weights, warmth = _weights(np.nan_to_num(gains, nan=-np.inf), expected, rough)
        mean, covariance = _moments(draws, weights)
        if warmth < best or kept is None:
            best, kept = warmth, (draws, scores, weights)
        if warmth <= rough:
            break
    return kept


def _within(rng, mean, covariance, plain):
    """Return draws (DRAWS, k) of a normal distribution where `plain` (k,) are between 0 and 1."""
    kept = np.empty((0, len(mean)))
    while len(kept) < DRAWS:
        draws = rng.multivariate_normal(mean, covariance, 4 * DRAWS)
        inside = ~plain | (draws > 0.0) & (draws < 1.0)
        kept = np.concatenate([kept, draws[inside.all(axis=1)]])
    return kept[:DRAWS]


def _log_density(draws, mean, covariance):
    """Return that (N,) of a normal distribution at draws (N, k), but for a constant."""
    off = draws - mean
    return -0.5 * np.einsum('ij,ij->i', off, np.linalg.solve(covariance, off.T).T)


def _weights(gains, expected, coldest):
    """
    Return weights (N,) of draws, and the temperature [nats] at which COUNT of them count.

    expected (N,): logarithm of how much more often than they were drawn they are expected.
    """
    for warmth in coldest * 1.2 ** np.arange(80.0):
        logarithm = gains / warmth + expected
        weights = np.exp(logarithm - logarithm.max())
        weights /= weights.sum()
        if 1.0 / (weights ** 2).sum() >= COUNT:
            break
    return weights, warmth


def _moments(draws, weights):
    """Return mean (k,) and covariance (k, k) of weighed draws (N, k)."""
    mean = weights @ draws
    off = draws - mean
    return mean, (off * weights[:, None]).T @ off


def _off_usual(hypothesis, residual):
    """Return the RMS [-] of the logarithm of the crossing links' inertia over its usual."""
    (joint, column), = hypothesis.columns.items()
    logarithm = residual.x.play.off_usual(joint)
    weights = residual.weights[:, joint] * column[:, 0] ** 2
    return float(np.sqrt(weights @ logarithm ** 2 / max(weights.sum(), 1e-300)))
