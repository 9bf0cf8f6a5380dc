"""
Parameters that physics allows no sign but plus, and that a model surely has below zero.

A joint that drives itself, or a rotor that helps, is no figure of a drive: something the model
lacks has gone into it. What is found beside it stands on a wrong footing.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..diagnosis import CONFIRMED, SUSPECTED, UNKNOWN

# Standard deviations below zero from which on a parameter surely is.
SURE = 2.0


@dataclass(frozen=True)
class Impossible:
    """One such parameter: joint index, effect, parameter, mean and std in its unit."""

    joint: int
    effect: str
    parameter: str
    mean: float
    std: float
    unit: str

    def said(self, joints, model):
        """Return the sentence; joints: names, model: which one is meant."""
        return (f'{joints[self.joint]}: {model} is impossible at this joint: {self.parameter} of '
                f'{self.effect} {self.mean:.3g} ± {SURE * self.std:.2g} {self.unit} (two '
                'standard deviations), and physics allows none below zero')


def impossible(model):
    """Return the Impossible parameters of a TorqueModel."""
    std, found = np.sqrt(np.diag(model.covariance)), []
    for use, where in model.slices():
        mean, doubt = model.mean[where], std[where]
        found += [Impossible(use.joint, use.name, *_named(use.effect, k, mean[k], doubt[k]))
                  for k in use.effect.positive if mean[k] < -SURE * doubt[k]]
    return tuple(found)


def _named(effect, k, mean, std):
    name, unit = effect.parameters[k]
    return name, float(mean), float(std), unit


def on_wrong_footing(findings, joints, model, better):
    """
    Return (Findings, sentences): suspected is what mainly acts where the better model is wrong.

    joints: names (n,).
    """
    before, after = impossible(model), impossible(better)
    told = [] if model is better else [p.said(joints, 'the model written') for p in after]
    told = [p.said(joints, 'the model that was diagnosed') for p in before] + told
    wrong = {joints[p.joint] for p in after}
    return tuple(replace(f, verdict=SUSPECTED) if _stands_on(f, joints, wrong) else f
                 for f in findings), tuple(told)


def _stands_on(finding, joints, wrong):
    return finding.verdict == CONFIRMED and not finding.recording and finding.name != UNKNOWN \
        and joints[int(np.argmax(finding.explained))] in wrong
