"""Offer a learned correction where, and only where, an effect stays unknown."""

from dataclasses import replace

import numpy as np

from .add import identified_again
from .diagnosis import UNKNOWN, Correction
from .measured.find import use_of

# What a correction can be a function of, and the field of EffectInput that holds it.
FUNCTIONS = {'velocity': ('learned_velocity_correction', 'v'),
             'position': ('learned_position_correction', 'q')}
# What is told of the error of recordings kept for the test: so much less of it, or so much more.
BETTER, WORSE = 0.95, 1.02


def offered(model, findings, evidence, judged):
    """
    Return the Correction of unknown effects that follow one variable of their joint, or None.

    model: the better TorqueModel; judged(TorqueModel) -> RMSE (n,) on test data, and the residual
    there while joints slide (n,), as of Residuals.
    """
    uses = list(model.uses)
    for finding in findings:
        if finding.name != UNKNOWN or len(finding.joints) != 1 \
                or finding.variables[0] not in FUNCTIONS:
            continue
        name, attribute = FUNCTIONS[finding.variables[0]]
        joint = model.robot.joints.index(finding.joints[0])
        reach = max(np.abs(getattr(e.motion, attribute)[:, joint]).max() for e in evidence)
        uses.append(use_of(name, joint, {'reach': float(reach)}))
    if len(uses) == len(model.uses):
        return None
    corrected = identified_again(model, tuple(uses), evidence)
    return Correction(corrected, *judged(corrected))


def with_correction(diagnosis, correction):
    """Return the Diagnosis with a Correction and a sentence that marks it."""
    if correction is None:
        return diagnosis
    smaller = _changes(diagnosis, correction, lambda before, after: after < BETTER * before)
    larger = _changes(diagnosis, correction, lambda before, after: after > WORSE * before)
    said = ('model_with_correction.yaml holds a learned function in place of what is unknown; it '
            f'is no explanation. Torque errors that are smaller with it: {smaller}; larger: '
            f'{larger}')
    return replace(diagnosis, correction=correction, remains=(*diagnosis.remains, said))


def _changes(diagnosis, correction, told):
    """Return in words the errors at joints for which told(before, after) holds."""
    return ', '.join(
        f'{name} {before:.3g} -> {after:.3g} Nm' for name, before, after in
        zip(diagnosis.joints, diagnosis.after, correction.after) if told(before, after)) or 'none'
