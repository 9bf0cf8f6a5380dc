"""
Does one recording not agree with the others, whatever is found?

Another arm of the same kind, another tool, a bolt that came loose in between: what differs from
recording to recording and not within one looks like an effect of time, and is none of the arm's.
"""

import numpy as np

from ...identification.evidence import recording_numbers
from ..tracing.trace import UNEXPECTED
from .unknown_temperature import lacks_temperature

# A joint is off in one recording by so many times what it is in the others, and its noise.
TIMES, NOISE = 3.0, 3.0


def odd_recordings(model, evidence, left_by, expected_by):
    """
    Return a sentence on each recording that does not agree with the others; Evidence of all.

    left_by(Evidence of one): what the better model leaves there while joints slide (n,) [Nm];
    expected_by(the same): what the model says to expect (n,) [Nm], asked where a temperature is
    not known; model: the TorqueModel given, whose noise holds no misfit.
    """
    parts = {}
    for number, part in zip(recording_numbers(evidence), evidence):
        parts.setdefault(number, []).append(part)
    if len(parts) < 2:
        return []
    left = np.array([left_by(own) for own in parts.values()])
    odd = [_odd(left, k, np.maximum(NOISE * model.noise, _of_temperature(model, own, expected_by)))
           for k, own in enumerate(parts.values())]
    return [_sentence(model.robot.joints, own[0].name, left, k, odd[k])
            for k, own in enumerate(parts.values()) if odd[k].any()]


def _of_temperature(model, parts, expected_by):
    """Return what friction as of a temperature that nobody knows may leave (n,) [Nm], else 0."""
    lacks = np.any([lacks_temperature(model, e) for e in parts], axis=0)
    return np.where(lacks, UNEXPECTED * expected_by(parts), 0.0) if lacks.any() else 0.0


def _others(left, k):
    """Return the median (n,) of what is left in the other recordings, infinite where unknown."""
    others = np.delete(left, k, axis=0)
    return np.array([np.median(o[np.isfinite(o)]) if np.isfinite(o).any() else np.inf
                     for o in others.T])


def _odd(left, k, noise):
    """Tell which joints (n,) are off in recording k and not in the others."""
    own = np.nan_to_num(left[k])
    return (own > TIMES * _others(left, k)) & (own > noise)


def _sentence(joints, name, left, k, odd):
    usual = _others(left, k)
    j = int(np.argmax(np.where(odd, left[k] / usual, 0.0)))
    return (f'cannot tell whether {name} is of the same arm in the same state as the others: with '
            f'everything that was found {joints[j]} is off by {left[k, j]:.2g} Nm there and by '
            f'{usual[j]:.2g} Nm in the others; another arm, another tool, a load or contact '
            'in it, or something that changed in between? Diagnose it by itself')
