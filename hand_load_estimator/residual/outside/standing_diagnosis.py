"""The diagnosis of an arm that only stands: what pushed it, and nothing else."""

from dataclasses import replace

import numpy as np

from ...errors import RecordingError
from ..diagnosis import Diagnosis
from ..measured.find import find_residual
from .contact import ELSEWHERE
from .disturbance_findings import disturbance_findings
from .standing import EXPLAINED, is_held, Standing


def only_stands(evidence):
    """Tell whether an arm is held in a pose in every one of its recordings, Evidence each."""
    return all(map(is_held, evidence))


def diagnose_standing(model, evidence, seconds):
    """
    Return the Diagnosis of recordings in which a TorqueModel's arm stands; seconds: spent on it.

    Raises RecordingError where nothing shows: at rest friction hides all that is the arm's own.
    """
    residual = find_residual(model, evidence)
    standing = Standing(model, evidence, residual)
    names = tuple(e.name for e in evidence)
    if not standing.found:
        raise RecordingError(f'{", ".join(names)}: no joint moves, and at rest friction hides '
                             'everything; record a motion of `hand_load excite`')
    findings = disturbance_findings(model.robot, names,
                                    replace(residual, residual=standing.torque), standing.found)
    unknown = np.full(model.robot.n, np.nan)
    return Diagnosis(
        model.robot.name, tuple(model.robot.joints), unknown, unknown, unknown, findings, unknown,
        ('cannot tell anything of the arm itself because no joint moves, and at rest friction '
         'hides it; record a motion of `hand_load excite`', *_elsewhere(names, standing.found)),
        recordings=names, tested_on='nothing, because no joint moves', seconds=seconds())


def _elsewhere(names, found):
    """Return a sentence on each contact that a force on the hand does not explain."""
    return [f'cannot tell where on the arm the push {one.start[0]:.1f} s after the start of '
            f'{names[one.owner]} was because a force on the hand explains less than '
            f'{100 * EXPLAINED:.0f} % of the torques, and friction at rest may hide what would '
            'tell'
            for one in found if one.start and one.cause.kind.name == ELSEWHERE]
