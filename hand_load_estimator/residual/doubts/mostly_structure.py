"""Joints of whose residual the larger part is structure that has no name: `unknown`."""

from dataclasses import replace

import numpy as np

from ...effects import NEEDS_TEMPERATURE
from ..diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED, UNKNOWN
from ..measured.rest import rest_of
from ..measured.structure import CONSTANT
from ..pictures_left import pictures_left
from .not_named import not_named
from .unknown import follows_words

# Share of the variance that is surely structure, after everything found.
SHARE = 0.5
TIME = 'time'
# What something that drifts has on an average, and what a temperature that drifts as well does.
_AVERAGES = frozenset({'torque_offset', 'friction_asymmetry'}) | NEEDS_TEMPERATURE


def mostly_structure(robot, residual, rest, findings, structure, trials):
    """
    Return Findings of suspected `unknown` effects, where none is named yet.

    rest (N, n) [Nm]: what is left of a Residual after everything found; structure: (Structure
    before, Structure after). Of recordings that were diagnosed, never of those kept for the test.
    Where something acted from outside nothing is added.
    """
    left = rest_of(np.where(residual.moving & (residual.weights > 0.0), rest, np.nan), residual.dt,
                   residual.messages, residual.owner)
    told = {name for f in findings for name in f.joints
            if f.name == UNKNOWN or (f.recording and f.verdict == CONFIRMED)}
    named = not_named(structure, robot.joints)
    chance = Evidence(np.nan, np.nan, np.nan, residual.observations, trials, np.nan)
    found = []
    for j, name in enumerate(robot.joints):
        if left.least_structure[j] > SHARE and name not in told:
            # That it has a mean is no dependence.
            variables = tuple(what for what, _ in named[j] if what != CONSTANT) or (TIME,)
            found.append(Finding(
                UNKNOWN, (name,), {}, np.zeros(robot.n),
                replace(chance, rms=float(left.rms[j])), (),
                'no effect of the vocabulary fits; what is left is mostly structure and '
                + follows_words(variables), False, SUSPECTED,
                pictures_left(robot, residual, rest, j, variables), variables))
    return tuple(found)


def drifting(findings, joints, structure):
    """
    Return (Findings, sentences): suspected is what may be the average of something that drifts.

    That is at joints, of these names, of whose residual the larger part is structure of which time
    foretells the larger part; structure: (Structure before, Structure after).
    """
    follows = dict(zip(joints, map(dict, not_named(structure, joints))))
    drift = {name for f in findings if f.name == UNKNOWN
             for name in f.joints if follows[name].get(TIME, 0.0) > SHARE}
    only = [f.verdict == CONFIRMED and f.name in _AVERAGES and drift >= set(f.joints)
            for f in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if o else f for f, o in zip(findings, only)),
            tuple(f'{", ".join(f.joints)}: {f.name} is only suspected: most of what it leaves '
                  'there follows time, of which it may be the average'
                  for f, o in zip(findings, only) if o))
