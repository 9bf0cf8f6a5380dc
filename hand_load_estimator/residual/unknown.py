"""What no effect explains: joints whose residual keeps its structure, and its rhythm in time."""

import numpy as np

from .diagnosis import SUSPECTED, UNKNOWN, Evidence, Finding, Picture
from .structure import followed

# Of the residual's structure more than this share is left, and it is so many times the noise.
SHARE, TIMES_NOISE = 0.5, 1.5
# A function of one variable explains at least this share, a rhythm at least that.
FOLLOWS, RHYTHMIC = 0.4, 0.3
SPECTRUM = 512   # samples of one periodogram


def left_over(robot, blocks):
    """Return the residual (N, n) [Nm] after everything found."""
    return np.stack([blocks.left_over(j) for j in range(robot.n)], axis=1)


def _rms(values, rows):
    count = np.maximum(rows.sum(axis=0), 1)
    return np.sqrt(np.where(rows, values ** 2, 0.0).sum(axis=0) / count)


def unexplained_joints(residual, rest):
    """
    Return the indices of joints whose residual stays structured after everything found.

    rest (N, n) [Nm].
    """
    rows = residual.moving & (residual.weights > 0.0)
    noise = residual.noise
    first, last = (np.sqrt(np.maximum(_rms(values, rows) ** 2 - noise ** 2, 0.0))
                   for values in (residual.residual, rest))
    return tuple(int(j) for j in np.flatnonzero(
        (last > SHARE * first) & (last > TIMES_NOISE * noise)))


def unknown_left(model, residual, rest, left, trace):
    """
    Return Findings for joints no effect explains: of the variable they follow, or in time.

    Joints without a variable of their own are one finding, with the rhythm they show.
    """
    known = {j for step in trace.steps for j in step.chosen.joints
             if step.chosen.name == UNKNOWN}
    joints = [j for j in left if j not in known]
    follows = {j: followed(model.robot, residual, rest[:, j], j) for j in joints}
    found = [_finding(model, residual, rest, [j], variable, {}, trace.trials)
             for j, (variable, share) in follows.items() if share > FOLLOWS]
    restless = [j for j, (_, share) in follows.items() if not share > FOLLOWS]
    if restless:
        frequency, share = rhythm(residual, rest[:, restless])
        parameters = {'frequency': (frequency, float('nan'), 'Hz')} if share > RHYTHMIC else {}
        found.append(_finding(model, residual, rest, restless, 'time', parameters, trace.trials))
    return tuple(found)


def _finding(model, residual, rest, joints, variable, parameters, trials):
    rms = float(_rms(rest, residual.moving)[joints].max())
    evidence = Evidence(np.nan, np.nan, np.nan, len(residual.starts), trials, rms)
    names = tuple(model.robot.joints[j] for j in joints)
    return Finding(UNKNOWN, names, parameters, np.zeros(model.robot.n), evidence, (),
                   f'no effect of the vocabulary fits; what is left depends on {variable}', False,
                   SUSPECTED, (_picture(model, residual, rest, joints[0]),), (variable,))


def rhythm(residual, rest):
    """Return the strongest frequency [Hz] in rest (N, k) [Nm] and its share of the power."""
    dt = float(np.median(residual.dt))
    power = np.zeros(SPECTRUM // 2 + 1)
    for owner in np.unique(residual.owner):
        values = rest[residual.owner == owner]
        for start in range(0, len(values) - SPECTRUM + 1, SPECTRUM // 2):
            part = values[start:start + SPECTRUM]
            part = (part - part.mean(axis=0)) * np.hanning(SPECTRUM)[:, None]
            power += (np.abs(np.fft.rfft(part, axis=0)) ** 2).sum(axis=1)
    if not power.any():
        return 0.0, 0.0
    peak = int(np.argmax(power[2:])) + 2
    near = slice(max(peak - 3, 0), peak + 4)
    return peak / (SPECTRUM * dt), float(power[near].sum() / power.sum())


def _picture(model, residual, rest, j):
    """Return a Picture of the strongest ten seconds of what is left of joint j."""
    time = np.cumsum(residual.dt)
    width = max(8, int(10.0 / np.median(residual.dt)))
    energy = np.convolve(rest[:, j] ** 2, np.ones(width), 'valid')
    first = int(np.argmax(energy)) if len(energy) else 0
    rows = slice(first, first + width)
    zero = np.zeros(len(rest[rows]))
    return Picture(model.robot.joints[j], 'time [s]', time[rows] - time[rows][0], rest[rows, j],
                   zero, zero, zero, zero)
