"""
A spring and a cable found on one joint that never goes round.

Over less than a whole turn a spring's pull is one more smooth function of position, and what a
cable does is a series of such functions that ends somewhere: one of both may be a further term of
the other.
"""

from dataclasses import replace

import numpy as np

from ..diagnosis import CONFIRMED, SUSPECTED
from ..tracing.confusable import advice

_ALIKE = ('cable_drag', 'gravity_spring')
WHOLE_TURN = 2.0 * np.pi


def further_terms(findings, model, residual):
    """
    Return (Findings, sentences): of a spring and a cable on one joint only one is confirmed.

    residual: the Residual of the TorqueModel that was diagnosed, which tells how far each joint
    went. The one that gains less beside the other is suspected, and so is one beside another that
    the model has already.
    """
    said = [_further_term(finding, findings, model, residual) for finding in findings]
    return (tuple(replace(f, verdict=SUSPECTED, advice=advice(f.name, _ALIKE)) if why else f
                  for f, why in zip(findings, said)), tuple(why for why in said if why))


def _further_term(finding, findings, model, residual):
    """Return in words why a Finding may be a further term of another, or ''."""
    if finding.verdict != CONFIRMED or finding.name not in _ALIKE:
        return ''
    (name,), j = finding.joints, model.robot.joints.index(finding.joints[0])
    (other,) = set(_ALIKE) - {finding.name}
    larger = any(f.name == other and f.joints == finding.joints
                 and f.evidence.gain > finding.evidence.gain for f in findings)
    declared = not finding.changed and any((use.name, use.joint) == (other, j)
                                           for use in model.uses)
    turned = _turned(residual, j)
    if not (larger or declared) or turned >= WHOLE_TURN:
        return ''
    return (f'{name}: {finding.name} is only suspected: the joint went through {turned:.2g} rad, '
            f'and over less than a whole turn it may be a further term of the {other} there')


def _turned(residual, j):
    """Return how far joint j went [rad] where its torque tells anything."""
    told = residual.x.q[residual.weights[:, j] > 0.0, j]
    return float(np.ptp(told)) if len(told) else 0.0
