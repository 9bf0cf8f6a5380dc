"""
An effort that comes late because it was filtered, not delayed.

A first-order lag of time constant T shows slow torque T late, as a delay of T does. They part by
T^2 / 2 times the torque's second derivative, which motions seldom tell.
"""

from dataclasses import replace

import numpy as np

from ..diagnosis import Alternative, CONFIRMED, SUSPECTED
from .candidate import ahead, alike, evaluated, hypotheses_of, SIGMAS, with_hypotheses

EFFORT_FILTER = 'effort_filter'
# A lag is delays of all lengths: these, of its time constant, stand for them.
_DELAYS = -np.log1p(-(np.arange(8) + 0.5) / 8.0)
_DELAYS /= _DELAYS.mean()


def filtered_instead(robot, candidate, blocks, residual):
    """Return [Alternative] where Blocks do not tell a Candidate, a delay, from a filter, or []."""
    lagging = [replace(h, columns=_lagging(h, residual.x)) for h in hypotheses_of(candidate)]
    delayed = evaluated(candidate, blocks)
    filtered = replace(evaluated(with_hypotheses(candidate, lagging), blocks), name=EFFORT_FILTER)
    if not alike(delayed, filtered) and filtered.gain < delayed.gain:
        return []
    less = ahead(delayed, filtered)
    return [Alternative(EFFORT_FILTER, tuple(robot.joints[j] for j in candidate.joints),
                        less.gain, less.std)]


def without_filters(findings):
    """Return (Findings, sentences): suspected are delays that a filter surely explains better."""
    better = [f.verdict == CONFIRMED and any(
        other.name == EFFORT_FILTER and other.behind < -SIGMAS * other.std
        for other in f.alternatives) for f in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if b else f for f, b in zip(findings, better)),
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected, because a filter of the '
                  'effort explains surely more' for f, b in zip(findings, better) if b))


def _lagging(hypothesis, x):
    """Return the columns {joint: (N, 1)} of a lag as long as a Hypothesis' delay."""
    late = np.mean([x.late(hypothesis.shape['shift'] * part) for part in _DELAYS], axis=0)
    return {j: late[:, j, None] * hypothesis.scale for j in hypothesis.columns}
