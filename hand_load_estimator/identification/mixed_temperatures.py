"""Recordings without a joint's temperature beside others that have it."""

import numpy as np


def mixed_temperatures(robot, evidence):
    """
    Return a sentence for each of Evidence that never knows a temperature others know.

    Its friction counts as of the reference temperature, so what temperature does comes out wrong.
    """
    known = np.array([np.isfinite(e.motion.temperature).any(axis=0) for e in evidence])
    lacking = known.any(axis=0) & ~known
    return [f'WARNING: {e.name} holds no temperature of '
            f'{", ".join(name for name, lacks in zip(robot.joints, row) if lacks)}, which other '
            f'recordings have: its friction counts as of {robot.reference_temperature:g} degC, '
            'and what temperature does to it comes out wrong; leave it out, or record it with '
            'temperatures' for e, row in zip(evidence, lacking) if row.any()]
