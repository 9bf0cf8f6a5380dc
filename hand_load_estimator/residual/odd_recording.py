"""
Does one recording not agree with the others, whatever is found?

Another arm of the same kind, another tool, a bolt that came loose in between: what differs from
recording to recording and not within one looks like an effect of time, and is none of the arm's.
"""

import numpy as np

from ..sliding import sliding_rms
from .find import find_residual

# A joint is off in one recording by so many times what it is in the others, and its noise.
TIMES, NOISE = 3.0, 3.0


def odd_recordings(model, evidence):
    """Return a sentence on each recording that a TorqueModel of all does not fit; Evidence."""
    names = list(dict.fromkeys(e.name for e in evidence))
    if len(names) < 2:
        return []
    left = np.array([_left(model, [e for e in evidence if e.name == name]) for name in names])
    return [sentence for k, name in enumerate(names)
            for sentence in _sentence(model, name, left[k], np.delete(left, k, axis=0))]


def _left(model, parts):
    """Return what a model leaves of the parts of one recording while joints slide (n,) [Nm]."""
    residual = find_residual(model, parts, cut=False)
    return sliding_rms(residual.residual, residual.sliding, residual.dt, residual.owner)


def _sentence(model, name, own, others):
    known = np.isfinite(others).any(axis=0) & np.isfinite(own)
    usual = np.array([np.median(o[np.isfinite(o)]) if k else np.inf
                      for o, k in zip(others.T, known)])
    odd = np.flatnonzero(known & (own > TIMES * usual) & (own > NOISE * model.noise))
    if not len(odd):
        return []
    j = odd[np.argmax(own[odd] / usual[odd])]
    return [f'cannot tell whether {name} is of the same arm in the same state as the others: with '
            f'everything that was found {model.robot.joints[j]} is off by {own[j]:.2g} Nm there '
            f'and by {usual[j]:.2g} Nm in the others; another arm, another tool, or something '
            'that changed in between? Diagnose it by itself']
