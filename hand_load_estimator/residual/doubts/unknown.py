"""What no effect explains: joints whose residual keeps its structure, and its rhythm in time."""

from dataclasses import replace

import numpy as np

from ..diagnosis import CONFIRMED, SUSPECTED, UNKNOWN, Evidence, Finding
from ..measured.rhythm import ringing
from ..measured.structure import followed, TEMPERATURE
from ..pictures_left import pictures_left
from ..tracing.trace import UNKNOWN_FACTOR
from .function_left import function_left
from .not_named import MOTION_OF, not_named

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

    Of a variable it is confirmed where that tells surely more than what is named (function_left).
    Joints without a variable of their own that ring are one finding, confirmed, as recordings tell
    that did not choose the frequency. What others follow is asked of structure, (Structure before,
    Structure after), which knows temperature and the motion of all joints; where that says
    nothing, either, all that is known is that time goes on.
    """
    known = {j for step in trace.steps for j in step.chosen.joints
             if step.chosen.name == UNKNOWN}
    joints = [j for j in left if j not in known]
    told = {j: function_left(model.robot, trace, j) for j in joints}
    joints = [j for j in joints if not told[j]]
    follows = {j: followed(model.robot, residual, rest[:, j], j) for j in joints}
    chance = Evidence(np.nan, np.nan, np.nan, residual.observations, trace.trials, np.nan)

    def found_in(joints, variable, evidence=chance):
        return _finding(model, residual, rest, joints, variable, evidence)
    found = [_told(found_in([j], function.variable, function.evidence), function, j)
             for j, function in told.items() if function]
    found += [found_in([j], variable) for j, (variable, share) in follows.items()
              if share > FOLLOWS]
    restless = [j for j, (_, share) in follows.items() if not share > FOLLOWS]
    if not restless:
        return tuple(found)
    swings, restless = _swings(residual, rest, restless, trace, found_in)
    found += swings
    farther = {j: _farther(structure, model.robot.joints, j) for j in restless}
    found += [found_in([j], variable) for j, variable in farther.items() if variable]
    restless = [j for j in restless if not farther[j]]
    return (*found, found_in(restless, 'time')) if restless else tuple(found)


def _swings(residual, rest, joints, trace, found_in):
    """Return the Findings, one or none, of joints (indices) that ring, and the other joints."""
    motion, needed = np.hstack([residual.x.v, residual.x.a]), UNKNOWN_FACTOR * trace.needed
    found = ringing(rest[:, joints], motion, residual.dt, residual.owner, needed)
    if found is None:
        return [], joints
    rhythm, columns = found
    evidence = Evidence(rhythm.gain, rhythm.gain_std, needed, len(rhythm.gains), trace.trials,
                        np.nan)
    those = [joints[k] for k in columns]
    return ([_swinging(found_in(those, 'time', evidence), rhythm, those)],
            [j for j in joints if j not in those])


def _farther(structure, joints, j):
    """Return what is no variable of joint j's own motion and its rest follows, or ''."""
    # Of structure, and here as of `followed` of the whole.
    part = structure[1].structured[j]
    return next((what for what, share in not_named(structure, joints)[j]
                 if (what == TEMPERATURE or what.startswith(MOTION_OF))
                 and share * part > FOLLOWS), '')


def _told(finding, function, j):
    """Return a Finding of joint j, confirmed by a FunctionLeft."""
    explained = finding.explained.copy()
    explained[j] = function.explained
    return replace(finding, explained=explained, verdict=CONFIRMED)


def _swinging(finding, rhythm, joints):
    """Return a Finding of joints (indices), confirmed by a Rhythm; explained: what rings."""
    explained = finding.explained.copy()
    explained[joints] = rhythm.share
    return replace(finding, parameters={'frequency': (rhythm.frequency, rhythm.scatter, 'Hz')},
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
