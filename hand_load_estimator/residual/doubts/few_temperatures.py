"""
Effects of temperature that no recording was foretold from others of another temperature.

Three recordings and more are held out each in turn, and with them their temperatures; fewer are
held out in spans, whose temperature is in what is fitted, too. Between one cold and one warm run
anything may have happened, which looks like an effect of temperature.
"""

from dataclasses import replace

import numpy as np

from ...effects import NEEDS_TEMPERATURE
from ...identification.evidence import recording_numbers
from ..diagnosis import CONFIRMED, SUSPECTED
from ..measured.folds import SEVERAL
from .limits import LEAST_WARMING


def between_two_temperatures(findings, joints, evidence):
    """
    Return (Findings, sentences): suspected is what may be any other difference of two recordings.

    joints: names (n,); a joint that warms within a recording tells by itself.
    """
    numbers = np.array(recording_numbers(evidence))
    if len(np.unique(numbers)) >= SEVERAL:
        return findings, ()
    spans = np.max([_spans(np.concatenate([e.motion.temperature for e, own in zip(
        evidence, numbers == number) if own])) for number in np.unique(numbers)], axis=0)
    warming = {name for name, span in zip(joints, spans) if span >= LEAST_WARMING}
    only = [f.verdict == CONFIRMED and f.name in NEEDS_TEMPERATURE and not warming & set(f.joints)
            for f in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if o else f for f, o in zip(findings, only)),
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected: no recording warms, and of '
                  'fewer than three none is foretold from other temperatures; record a third'
                  for f, o in zip(findings, only) if o))


def _spans(temperature):
    """Return by how much each of the columns (N, n) changes where it is known, 0 where never."""
    known = [column[np.isfinite(column)] for column in temperature.T]
    return [float(np.ptp(column)) if len(column) else 0.0 for column in known]
