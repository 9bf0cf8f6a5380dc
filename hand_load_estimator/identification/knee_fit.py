"""
Knees estimated with everything else (Muggeo 2003): where they are, and what their doubt adds.

The torque is made linear in the knees too. Their shifts are solved for beside x (eq. 11), until
they are at rest; what is then known of x is known for knees that may be a little elsewhere.
"""

from dataclasses import replace

import numpy as np

from ..effects.knee import KNEE
from ..torque.columns import effect_slices

TURNS = 3
DOUBT = 10.0      # [K] how far a knee may be from where a search found it
STEP = 3.0        # [K] the furthest a knee goes in one turn
HALF_WIDTH = 0.5  # [K] of the difference that tells what moving a knee does


def with_knees_fitted(system, uses, known, mean, covariance, weights):
    """
    Return (uses, x (P,), covariance (P, P)) with the knees of uses where they fit best.

    system: the System of uses as they are, whose columns go with the knees; known: the same uses
    with what was known of their knees before, mean, covariance: of x; weights (N, n). Each knee's
    standard deviation is then in its use's shape_std. Where friction levels off nowhere this is
    the plain solution.
    """
    x, posterior = system.solve(mean, covariance, weights)
    n, size, uses = system.torque.shape[1], len(mean), list(uses)
    knees = [(k, where) for k, (use, where) in enumerate(effect_slices(n, uses))
             if KNEE.name in use.told_shape]
    if not knees:
        return tuple(uses), x, posterior
    wide = np.zeros((size + len(knees),) * 2)
    wide[:size, :size] = covariance
    wide[size:, size:] = np.diag([known[k].shape_std.get(KNEE.name, DOUBT) ** 2
                                  for k, _ in knees])
    for _ in range(TURNS):
        first = np.append(mean, [known[k].shape[KNEE.name] - uses[k].shape[KNEE.name]
                                 for k, _ in knees])
        more = np.zeros((*system.torque.shape, len(knees)))
        for i, (k, where) in enumerate(knees):
            more[:, uses[k].joint, i] = _per_kelvin(system, uses[k], x[where])
        both, posterior = system.with_more(more).solve(first, wide, weights)
        std = np.sqrt(np.diag(posterior)[size:])
        for i, (k, where) in enumerate(knees):
            uses[k] = _moved(uses[k], np.clip(both[size + i], -STEP, STEP), std[i])
            system.reshape(uses[k], where)
        x, _ = system.solve(mean, covariance, weights)
    return tuple(uses), x, posterior[:size, :size]


def _per_kelvin(system, use, values):
    """Return the torque (N,) [Nm/K] that a higher knee adds at parameters (k,)."""
    low, high = (system.columns_of(_moved(use, step)) @ values
                 for step in (-HALF_WIDTH, HALF_WIDTH))
    return (high - low) / (2.0 * HALF_WIDTH)


def _moved(use, step, std=np.nan):
    """Return the use with its knee moved by a step [K]."""
    knee = max(use.shape[KNEE.name] + float(step), HALF_WIDTH)
    return replace(use, shape={**use.shape, KNEE.name: knee}, shape_std={KNEE.name: float(std)})
