"""What acted from outside, in the words, numbers and pictures of a Diagnosis."""

from dataclasses import replace
from itertools import product

import numpy as np

from ..diagnosis import Alternative, CONFIRMED, Evidence, Finding, Picture, SUSPECTED
from ..tracing.confusable import CLOSE
from . import contact, load_change
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


def findings_again(robot, names, shown, better, odd=()):
    """
    Return (Findings, sentences) on Disturbances as the better model shows them.

    shown: pairs of a Residual and a Disturbance in it, each of a model without something; better:
    Residual and Disturbances of the better model on the same whole recordings. That model was
    fitted without these times; what is not found again with it was rather a part of something
    that goes on all the time. What pushes until the end, or from the start, of the only recording
    may be the arm, which is another then.
    """
    cleaner, again = better
    same, findings, told = _pairs([one for _, one in shown], again), [], []
    for residual, one in shown:
        if id(one) in same:
            found = same[id(one)]
            findings.append(_finding(robot, names, cleaner, found, odd))
            endless = ' or '.join(word for word, moment in (
                ('begin', found.start), ('end', found.end)) if moment is None)
            if len(names) == 1 and endless and not found.cause.kind.open_ended:
                findings[-1] = replace(findings[-1], verdict=SUSPECTED)
                told.append(f'{findings[-1].recording}: {findings[-1].name}{at(found)} is only '
                            f'suspected: it does not {endless} within the only recording '
                            'diagnosed, so it may be another offset of these joints')
            continue
        findings.append(_finding(robot, names, residual, one, odd))
        # Of an arm that is held nothing is foretold (standing.py).
        if np.isfinite(one.evidence):
            findings[-1] = replace(findings[-1], verdict=SUSPECTED)
            told.append(f'{findings[-1].recording}: {findings[-1].name}{at(one)} is only '
                        'suspected: it is not found again with the model written')
    return tuple(findings), tuple(told)


def _pairs(found, again):
    """Return {id of a Disturbance of `found`: the same of `again`}; each is one's only."""
    ranked = sorted(((_overlap(one, other), one, other) for one, other in product(found, again)
                     if np.isfinite(one.evidence)), key=lambda row: -row[0])
    same, taken = {}, set()
    for overlap, one, other in ranked:
        if overlap > 0.5 * min(_rows(one), _rows(other)) and id(one) not in same \
                and id(other) not in taken:
            same[id(one)] = other
            taken.add(id(other))
    return same


def _rows(one):
    return one.stop - one.first


def _overlap(one, other):
    """Return how many rows two Disturbances have in common."""
    return min(one.stop, other.stop) - max(one.first, other.first)


def at(one):
    """Return when a Disturbance began, in words, or '' where it was there from the start."""
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
    tied = one.margin is not None and one.margin < max(TIE, (1.0 - CLOSE) * one.evidence)
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
