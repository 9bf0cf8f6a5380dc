"""
Many joints that differ far, each by a cause of its own: another arm, or a model of another time.

A diagnosis changes a model where something happened to the arm. Where something different seems
to have happened to most joints at once, it is likelier that the model is of another specimen, of
another robot file, or from before an overhaul: then names and figures are no defects, and the arm
is to be identified anew.
"""

from dataclasses import replace

import numpy as np

from ...effects import EFFECTS
from ..diagnosis import SUSPECTED
from ..tracing.candidate import SIGMAS
from ..tracing.hypotheses import ONE_CAUSE

# A joint differs far where the old model leaves so many times the noise that it states.
FAR = 3.0
# A gain has one cause where it is the same at most of its joints: what supplies or reads them all.
# Two surely are not the same where they differ by this share of the larger.
OWN_GAINS = 0.5
_GAINS = ('torque_scale', 'torque_scale_temperature')


def of_another_state(findings, model, residual):
    """
    Return (Findings, sentences): none is confirmed where most joints differ by their own causes.

    residual: the Residual of the TorqueModel on what was diagnosed. What one cause does to all
    joints, or happened once, is none of a joint's own.
    """
    count = np.maximum(residual.moving.sum(axis=0), 1)
    rms = np.sqrt((residual.moving * residual.residual ** 2).sum(axis=0) / count)
    far = {name for name, times in zip(model.robot.joints, rms / model.noise) if times > FAR}
    own = {name for f in findings for name in _own_joints(f, findings)} & far
    n = model.robot.n
    if 2 * len(own) <= n:
        return findings, ()
    return (tuple(replace(f, verdict=SUSPECTED) if not f.recording else f for f in findings), (
        f'cannot tell defects from another arm, because {len(own)} of {n} joints differ from the '
        f'model by more than {FAR:g} times the noise it states, each by causes of its own: '
        'rather the model is of another specimen or robot file, or from before an overhaul; '
        'identify this arm anew (hand_load identify) instead of using the model written',))


def _own_joints(finding, findings):
    """Return the names of a Finding's joints that have a lasting cause of their own."""
    # What is only suspected differs all the same.
    if finding.recording:
        return ()
    if len(finding.joints) > 1:
        return _own_gains(finding) if finding.name in _GAINS else ()
    # What several joints show together is one cause, though one of them was found later.
    later = finding.name in ONE_CAUSE and any(
        f is not finding and f.name == finding.name for f in findings)
    return () if later else finding.joints


def _own_gains(finding):
    """Return the names of a Finding's joints whose gain is not the one of most of them."""
    (name, _), = EFFECTS[finding.name].parameters
    told = [finding.parameters.get(f'change_of_{name} ({joint})')
            or finding.parameters.get(f'{name} ({joint})') for joint in finding.joints]
    if None in told:
        return ()
    mean, std, _ = (np.array(values) for values in zip(*told))
    size = np.abs(mean)
    # Of a change that the model's own recordings show nobody knows the deviation.
    apart = np.fmax(SIGMAS * np.hypot(std[:, None], std), OWN_GAINS * np.maximum(
        size[:, None], size))
    alike = np.abs(mean[:, None] - mean) <= apart
    most = alike[np.argmax(alike.sum(axis=0))]
    if 2 * most.sum() <= len(mean):
        return finding.joints
    return tuple(joint for joint, one in zip(finding.joints, most) if not one)
