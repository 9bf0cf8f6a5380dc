"""
Many joints that differ far, each by a cause of its own: another arm, or a model of another time.

A diagnosis changes a model where something happened to the arm. Where something different seems
to have happened to most joints at once, it is likelier that the model is of another specimen, of
another robot file, or from before an overhaul: then names and figures are no defects, and the arm
is to be identified anew.
"""

from dataclasses import replace

import numpy as np

from ..effects import EFFECTS
from .candidate import SIGMAS
from .diagnosis import SUSPECTED

# A joint differs far where the old model leaves so many times the noise that it states.
FAR = 3.0
# A gain has one cause where it is the same at all its joints: what supplies or reads them all. It
# surely is not where gains differ by this share of the largest.
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
    own = {name for f in findings if _of_its_joints(f) for name in f.joints} & far
    n = model.robot.n
    if 2 * len(own) <= n:
        return findings, ()
    return (tuple(replace(f, verdict=SUSPECTED) if not f.recording else f for f in findings), (
        f'cannot tell defects from another arm, because {len(own)} of {n} joints differ from the '
        f'model by more than {FAR:g} times the noise it states, each by causes of its own: '
        'rather the model is of another specimen or robot file, or from before an overhaul; '
        'identify this arm anew (hand_load identify) instead of using the model written',))


def _of_its_joints(finding):
    """Tell whether a Finding is of each of its joints alone, and lasts."""
    # What is only suspected differs all the same; what several joints show together is one cause.
    return not finding.recording and (len(finding.joints) == 1 or _own_gains(finding))


def _own_gains(finding):
    """Tell whether a Finding is of gains that surely are not one and the same."""
    if finding.name not in _GAINS:
        return False
    (name, _), = EFFECTS[finding.name].parameters
    told = [finding.parameters.get(f'change_of_{name} ({joint})')
            or finding.parameters.get(f'{name} ({joint})') for joint in finding.joints]
    if None in told:
        return False
    mean, std, _ = zip(*told)
    least, most = int(np.argmin(mean)), int(np.argmax(mean))
    apart = mean[most] - mean[least]
    return bool(apart > SIGMAS * np.hypot(std[most], std[least])
                and apart > OWN_GAINS * np.abs(mean).max())
