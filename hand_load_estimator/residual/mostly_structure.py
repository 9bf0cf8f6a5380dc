"""Joints of whose residual the larger part is structure that has no name: `unknown`."""

import numpy as np

from .diagnosis import Evidence, Finding, SUSPECTED, UNKNOWN
from .not_named import not_named
from .rest import rest_of

# Share of the variance that is surely structure, after everything found.
SHARE = 0.5


def mostly_structure(joints, residual, rest, findings, structure, trials):
    """
    Return Findings of suspected `unknown` effects, where none is named yet.

    joints: names (n,); rest (N, n) [Nm]: what is left of a Residual after everything found;
    structure: (Structure before, Structure after). Of recordings that were diagnosed, never of
    those kept for the test. Where something acted from outside nothing is added.
    """
    left = rest_of(np.where(residual.moving & (residual.weights > 0.0), rest, np.nan), residual.dt,
                   residual.messages, residual.owner)
    told = {name for f in findings if f.name == UNKNOWN or f.recording for name in f.joints}
    follows = not_named(structure, joints)
    return tuple(_finding(name, tuple(what for what, _ in follows[j]) or ('time',), left.rms[j],
                          (len(joints), residual.observations, trials))
                 for j, name in enumerate(joints)
                 if left.least_structure[j] > SHARE and name not in told)


def _finding(joint, variables, rms, counts):
    n, observations, trials = counts
    return Finding(UNKNOWN, (joint,), {}, np.zeros(n),
                   Evidence(np.nan, np.nan, np.nan, observations, trials, float(rms)), (),
                   'no effect of the vocabulary fits; what is left is mostly structure and '
                   f'depends on {", ".join(variables)}', False, SUSPECTED, (), variables)
