"""What acted from outside, in the words, numbers and pictures of a Diagnosis."""

from dataclasses import replace

import numpy as np

from . import contact, load_change
from .diagnosis import Alternative, CONFIRMED, Evidence, Finding, Picture, SUSPECTED
from .disturbance import TIE

PARAMETERS = {contact.NAME: contact.contact_parameters,
              load_change.NAME: load_change.load_parameters}
ADVICE = {contact.NAME: 'hold the same while the hand turns and speeds up: a force from outside '
                        'does not turn with the hand and has no inertia',
          load_change.NAME: 'hold the same while the hand turns and speeds up: a load turns with '
                            'the hand and resists acceleration'}
# Joints that carry this share of the strongest joint's torque are named.
SHARE = 0.3
AROUND = 3.0             # [s] drawn before and after
POINTS, MOST_PICTURES = 60, 2


def disturbance_findings(robot, names, residual, found, odd=()):
    """
    Return the Findings on Disturbances.

    names: of the recordings; odd: joints with something unknown that goes on all the time, of
    which a disturbance may be a part.
    """
    return tuple(_finding(robot, names, residual, one, odd) for one in found)


def findings_again(robot, names, before, after, odd=()):
    """
    Return (Findings, sentences) on Disturbances as the better model shows them.

    before, after: Residual and Disturbances of the model diagnosed and of the better one, on the
    same whole recordings. The better model was fitted without these times, so it cannot have
    learnt them; what it explains all the same is a part of something that goes on all the time,
    and only suspected.
    """
    (residual, found), (cleaner, again) = before, after
    findings, told, taken = [], [], []
    for one in found:
        same = max(again, key=lambda other: _overlap(one, other), default=None)
        # Of an arm that is held nothing is foretold (standing.py).
        if not np.isfinite(one.evidence):
            findings.append(_finding(robot, names, residual, one, odd))
        elif same is None or _overlap(one, same) <= 0:
            findings.append(replace(_finding(robot, names, residual, one, odd),
                                    verdict=SUSPECTED))
            told.append(f'{findings[-1].recording}: {findings[-1].name}{_at(one)} is only '
                        'suspected: the model written explains the torques of that time without '
                        'it')
        elif not any(same is other for other in taken):
            taken.append(same)
            findings.append(_finding(robot, names, cleaner, same, odd))
    return tuple(findings), tuple(told)


def _overlap(one, other):
    """Return how many rows two Disturbances have in common."""
    return min(one.stop, other.stop) - max(one.first, other.first)


def _at(one):
    return f' at {one.start[0]:.1f} s' if one.start else ''


def _finding(robot, names, residual, one, odd):
    rows = slice(one.first, one.stop)
    kind = one.cause.kind
    torque = kind.columns[rows] @ (one.theta / kind.scale)
    rms = np.sqrt((torque ** 2).mean(axis=0))
    elsewhere = kind.name == contact.ELSEWHERE
    name = contact.NAME if elsewhere else kind.name
    parameters = contact.torque_parameters(one, robot.joints) if elsewhere \
        else PARAMETERS[name](one)
    parameters |= {name: (*moment, 's') for name, moment in
                   (('start', one.start), ('end', one.end)) if moment is not None}
    strong = np.flatnonzero(rms > SHARE * rms.max())
    tied = one.margin is not None and one.margin < TIE
    sure = not set(strong) & set(odd)
    order = strong[np.argsort(-rms[strong])]
    joints = tuple(robot.joints[j] for j in strong)
    return Finding(
        name, joints, parameters,
        one.explained,
        # It happens once: there is nothing else to test it on.
        Evidence(one.evidence, np.nan, one.needed, 1, one.tried, float(rms.max()), one.rival,
                 one.margin),
        (Alternative(one.rival, joints, one.margin, np.nan),) if tied else (),
        ADVICE[name] if tied else '', False, CONFIRMED if sure else SUSPECTED,
        tuple(_picture(robot, names[one.owner], residual, one, int(j))
              for j in order[:MOST_PICTURES]), recording=names[one.owner])


def _picture(robot, name, residual, one, j):
    """Return the residual of a joint over time with the disturbance's torque."""
    own = np.flatnonzero(residual.owner == one.owner)
    time = residual.time[own] - residual.time[own[0]]
    low, high = (residual.time[k] - residual.time[own[0]] for k in (one.first, one.stop - 1))
    near = own[(time > low - AROUND) & (time < high + AROUND)]
    columns = one.cause.kind.columns[near, j] / one.cause.kind.scale
    acts = (near >= one.first) & (near < one.stop)
    curve = np.where(acts, columns @ one.theta, 0.0)
    spread = np.where(acts, np.sqrt(np.einsum('ki,ij,kj->k', columns, one.covariance, columns)),
                      0.0)
    bins = np.array_split(np.arange(len(near)), min(POINTS, len(near)))
    mean = np.array([residual.residual[near[b], j].mean() for b in bins])
    error = np.array([residual.residual[near[b], j].std() / np.sqrt(max(len(b) / 5.0, 1.0))
                      for b in bins])
    x, middle, std = (np.array([values[b].mean() for b in bins]) for values in
                      (residual.time[near] - residual.time[own[0]], curve, spread))
    return Picture(robot.joints[j], f'time in {name} [s]', x, mean, error, middle,
                   middle - 1.96 * std, middle + 1.96 * std)
