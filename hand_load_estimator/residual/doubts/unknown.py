"""What no effect explains: joints whose residual keeps its structure, and its rhythm in time."""

from dataclasses import replace

import numpy as np

from ..diagnosis import CONFIRMED, SUSPECTED, UNKNOWN, Evidence, Finding
from ..measured.rhythm import rhythm
from ..measured.structure import CONSTANT, followed
from ..pictures_left import pictures_left
from ..tracing.trace import UNKNOWN_FACTOR
from .not_named import not_named

# Of the residual's structure more than this share is left, and it is so many times the noise.
SHARE, TIMES_NOISE = 0.5, 1.5
# A function of one variable explains at least this share.
FOLLOWS = 0.4


def left_over(robot, blocks):
    """Return the residual (N, n) [Nm] after everything found."""
    return np.stack([blocks.left_over(j) for j in range(robot.n)], axis=1)


def rms_of(values, rows):
    """Return the RMS (n,) of values (N, n) in rows (N, n) bool."""
    count = np.maximum(rows.sum(axis=0), 1)
    return np.sqrt(np.where(rows, values ** 2, 0.0).sum(axis=0) / count)


def unexplained_joints(residual, rest):
    """
    Return the indices of joints whose residual stays structured after everything found.

    rest (N, n) [Nm].
    """
    rows = residual.moving & (residual.weights > 0.0)
    noise = residual.noise
    first, last = (np.sqrt(np.maximum(rms_of(values, rows) ** 2 - noise ** 2, 0.0))
                   for values in (residual.residual, rest))
    return tuple(int(j) for j in np.flatnonzero(
        (last > SHARE * first) & (last > TIMES_NOISE * noise)))


def unknown_left(model, residual, rest, left, trace, structure):
    """
    Return Findings for joints no effect explains: of the variable they follow, or in time.

    structure: (Structure before, Structure after), which ask for temperature, time and the motion
    of all other joints, too. Joints without a variable of their own are one finding: confirmed
    where they ring, which recordings tell that did not choose the frequency; else all that is
    known is that time goes on.
    """
    known = {j for step in trace.steps for j in step.chosen.joints
             if step.chosen.name == UNKNOWN}
    joints = [j for j in left if j not in known]
    named = not_named(structure, model.robot.joints)
    follows = {j: _variable(model.robot, residual, rest[:, j], j, named[j]) for j in joints}
    chance = Evidence(np.nan, np.nan, np.nan, residual.observations, trace.trials, np.nan)
    found = [_finding(model, residual, rest, [j], variable, chance)
             for j, variable in follows.items() if variable]
    restless = [j for j, variable in follows.items() if not variable]
    if restless:
        motion = np.hstack([residual.x.v, residual.x.a])
        rings = rhythm(rest[:, restless], motion, residual.dt, residual.owner)
        needed = UNKNOWN_FACTOR * trace.needed
        if rings is not None and rings.sure(needed):
            evidence = Evidence(rings.gain, rings.gain_std, needed, len(rings.gains), trace.trials,
                                np.nan)
            found.append(_ringing(_finding(model, residual, rest, restless, 'time', evidence),
                                  rings, restless))
        else:
            found.append(_finding(model, residual, rest, restless, 'time', chance))
    return tuple(found)


def _variable(robot, residual, rest, j, named):
    """Return the variable that most of a joint's rest (N,) follows, or an empty string."""
    variable, share = followed(robot, residual, rest, j)
    if share > FOLLOWS:
        return variable
    # That it has a mean is no dependence.
    return next((what for what, share in named if what != CONSTANT and share > FOLLOWS), '')


def _ringing(finding, rings, joints):
    """Return a Finding of joints (indices), confirmed by a Rhythm; explained: what rings."""
    explained = finding.explained.copy()
    explained[joints] = rings.share
    return replace(finding, parameters={'frequency': (rings.frequency, rings.scatter, 'Hz')},
                   explained=explained, verdict=CONFIRMED)


def follows_words(variables):
    """Return what a residual does with variables, in words; time is the lack of any other."""
    return 'follows nothing of the motion closely' if variables == ('time',) else \
        f'depends on {", ".join(variables)}'


def _finding(model, residual, rest, joints, variable, evidence):
    rms = rms_of(rest, residual.moving)[joints]
    strongest = joints[int(rms.argmax())]
    names = tuple(model.robot.joints[j] for j in joints)
    return Finding(UNKNOWN, names, {}, np.zeros(model.robot.n),
                   replace(evidence, rms=float(rms.max())), (),
                   'no effect of the vocabulary fits; what is left '
                   + follows_words((variable,)), False, SUSPECTED,
                   pictures_left(model.robot, residual, rest, strongest, (variable,)),
                   (variable,))
