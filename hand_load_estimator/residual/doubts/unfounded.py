"""
Effects that the model written holds with figures which are none of what they are called.

A hypothesis is asked what physics allows of it; estimated together with everything else its
figures may become others. A share of a delay is no delay, and half of the time between two joint
states too short for one of a single joint. A peak of friction below the slowest motion that tells
friction is known by its tail only, one that has not fallen at the fastest is a level. What was
found beside the torque of the model as it was, late or misread, may be nothing beside the torque
as it is; and what is small beside another a rest that the formula of that leaves.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from ...effects import EFFECTS, LATE, PRESLIDING
from ..add import perhaps_too
from ..change_of import change_covariance
from ..diagnosis import CONFIRMED, SUSPECTED, UNKNOWN
from ..tracing.candidate import SIGMAS
from ..tracing.hypothesis import WHOLE

# [-] of a large effect's torque that its formula may leave; nats go with the square of it.
EXACT = 0.05
# Held-out blocks have told that there is something. Figures that chance makes as large as they are
# in more than the rest of this are none of it: two standard deviations of one figure.
CERTAIN = 0.95
# Directions of a covariance below this share of their own units are rounding.
ROUNDING = 1e-9


def of_another_kind(findings, interval, faint=()):
    """
    Return (Findings, sentences): suspected is what has figures of no such effect, or of none.

    interval [s]: between joint states; faint: (name, joints) of what the better model hardly
    holds (faint_in).
    """
    said = [_why(finding, interval) or _nothing(finding, faint) for finding in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if why else f for f, why in zip(findings, said)),
            tuple(why for why in said if why))


def _why(finding, interval):
    """Return in words why a Finding is not what it is called, or an empty string."""
    if finding.verdict != CONFIRMED or finding.name not in EFFECTS:
        return ''
    joints = ', '.join(finding.joints)
    for name, (mean, std, unit) in finding.parameters.items():
        plain = name.split(' (')[0]
        if finding.name == LATE and plain == 'share' \
                and abs(mean - 1.0) > max(WHOLE, SIGMAS * std):
            return (f'{joints}: time_delay is only suspected: all of the torque would come late, '
                    f'but the model written delays {mean:.3g} ± {2.0 * std:.2g} of it (two '
                    'standard deviations)')
        if finding.name == LATE and plain == 'delay' and len(finding.joints) == 1 \
                and mean < 0.5 * interval:
            return (f'{joints}: time_delay is only suspected: {1e3 * mean:.2g} ms is less than '
                    f'half of the {1e3 * interval:.2g} ms between two joint states, too short to '
                    'be told from what other effects leave')
        own = [s for s in EFFECTS[finding.name].shapes if s.name == plain]
        if any(s.slowest(mean) for s in own):
            return (f'{joints}: {finding.name} is only suspected: its {plain} is at or below '
                    f'{mean:.3g} {unit}, hardly faster than the slowest motion that tells '
                    'friction')
        if any(s.longest(mean) for s in own):
            return (f'{joints}: {finding.name} is only suspected: its {plain} is at or above '
                    f'{mean:.3g} {unit}, where it looks like another effect')
    return ''


def _nothing(finding, faint):
    """Return in words that nothing is left of a Finding in the better model, or ''."""
    if finding.verdict != CONFIRMED or (finding.name, finding.joints) not in faint:
        return ''
    return (f'{", ".join(finding.joints)}: {finding.name} is only suspected: estimated together '
            'with everything else it moves less torque than matters beside the noise')


def small_beside_others(findings):
    """
    Return (Findings, sentences): suspected is what gains too little beside others at its joints.

    No formula is exact: a large effect leaves a rest, which another effect may look like. What
    has no formula leaves none, nor what happened once and is cut out.
    """
    said = [_small(finding, findings) for finding in findings]
    return (tuple(replace(f, verdict=SUSPECTED) if why else f for f, why in zip(findings, said)),
            tuple(why for why in said if why))


def _small(finding, findings):
    """Return in words that a Finding is small beside others wherever it gains, or ''."""
    if finding.verdict != CONFIRMED:
        return ''
    named = [f for f in findings if f.verdict == CONFIRMED and f is not finding
             and f.name != UNKNOWN]
    own = {j: gain for j, gain in finding.evidence.by_joint.items() if gain > 0.0}
    larger = {}
    for joint, gain in own.items():
        most, name = max(((f.evidence.by_joint.get(joint, 0.0), f.name) for f in named),
                         default=(0.0, ''))
        if gain < EXACT ** 2 * most:
            larger[joint] = name
    elsewhere = sum(gain for joint, gain in own.items() if joint not in larger)
    if not larger or elsewhere >= finding.evidence.needed:
        return ''
    return (f'{", ".join(finding.joints)}: {finding.name} is only suspected: what it explains at '
            f'{" and ".join(larger)} is less than {100.0 * EXACT:g} % of the torque of '
            f'{" and ".join(dict.fromkeys(larger.values()))} there, which may be a rest of that')


def faint_in(model, better, trace):
    """
    Return {(name, joints)} of steps of which the better model holds too little to matter.

    model, better: TorqueModels before and after; trace: a finished Trace.
    """
    return {(step.chosen.name, tuple(model.robot.joints[j] for j in step.chosen.joints))
            for step in trace.steps if _faint(model, better, trace, step.chosen)}


def unsure_in(model, better, trace):
    """
    Return {(name, joints): joints} of steps, and where the better model may hold nothing of them.

    That is where all figures of an effect, or what they changed by, are within chance (Wald's
    test with the model's own covariance), by themselves and together with those of declared
    effects that it is not told from: the data tell the sum of these, and hardly any share. What
    joints have in common they show together, and a delay is held to be a whole.
    """
    found = {}
    for step in trace.steps:
        chosen, joints = step.chosen, model.robot.joints
        # Of presliding the travel is new, which is no figure of these.
        if chosen.name in (UNKNOWN, 'base_tilt', LATE, PRESLIDING) or chosen.common:
            continue
        found[chosen.name, tuple(joints[j] for j in chosen.joints)] = tuple(
            joints[h.joint] for h, _ in chosen.parts
            if not any(_sure(model, better, own) for own in _alone_and_not(model, step, h)))
    return found


def _alone_and_not(model, step, hypothesis):
    """Return lists of Hypotheses: one alone, and with what may have changed as well or instead."""
    others = sorted(perhaps_too(model, step, hypothesis))
    together = [replace(hypothesis, name=name, joint=joint) for name, joint in others]
    return [[hypothesis], *([[hypothesis, *together]] if together else [])]


def _sure(model, better, hypotheses):
    """Tell whether the better model surely holds something, or something new, of Hypotheses."""
    changed = [_changed(model, better, h) for h in hypotheses]
    where, change = map(np.concatenate, zip(*(pair[:2] for pair in changed)))
    covariance = better.covariance[np.ix_(where, where)]
    old = np.concatenate([before for *_, before in changed])
    compared = old >= 0
    of_change = change_covariance(model, better, old[compared], where[compared])
    if np.isfinite(of_change).all():
        covariance[np.ix_(compared, compared)] = of_change
    std = np.sqrt(np.diag(covariance))
    unit = np.where(std > 0.0, std, 1.0)
    values, axes = np.linalg.eigh(covariance / np.outer(unit, unit))
    told = values > ROUNDING
    square = np.sum((change / unit @ axes[:, told]) ** 2 / values[told])
    return bool(square > chi2.ppf(CERTAIN, told.sum()))


def _changed(model, better, hypothesis):
    """
    Return of a Hypothesis its places (k,) in the better x, what is new there, and the old places.

    Those are -1 where the old model has no such figures.
    """
    (shape, where), old = _place(better, hypothesis), _place(model, hypothesis)
    if old is None or old[0] != shape:
        return np.arange(where.start, where.stop), better.mean[where], np.full(
            where.stop - where.start, -1)
    return (np.arange(where.start, where.stop), better.mean[where] - model.mean[old[1]],
            np.arange(old[1].start, old[1].stop))


def _place(model, hypothesis):
    """Return the shape and the place in x of a Hypothesis in a TorqueModel, or None."""
    if hypothesis.name == 'link_inertia':
        return {}, slice(10 * hypothesis.joint, 10 * hypothesis.joint + 10)
    return next(((use.formula, where) for use, where in model.slices()
                 if (use.name, use.joint) == (hypothesis.name, hypothesis.joint)), None)


def without_unsure(findings, unsure):
    """
    Return (Findings, sentences) without joints where there may be nothing (unsure_in).

    Where that is all of them the Finding is suspected.
    """
    kept, told = [], []
    for finding in findings:
        none = unsure.get((finding.name, finding.joints), ())
        if not none or finding.verdict != CONFIRMED:
            kept.append(finding)
        elif len(none) == len(finding.joints):
            told.append(f'{", ".join(none)}: {finding.name} is only suspected: estimated together '
                        'with everything else all its figures are within chance of nothing')
            kept.append(replace(finding, verdict=SUSPECTED))
        else:
            told.append(f'{", ".join(none)}: no {finding.name} is told there: estimated together '
                        'with everything else its figures are within chance of nothing')
            kept.append(_elsewhere(finding, none))
    return tuple(kept), tuple(told)


def _elsewhere(finding, none):
    """Return a Finding of its other joints only, and with what they gain."""
    gains = finding.evidence.by_joint
    evidence = replace(
        finding.evidence, by_joint={j: gain for j, gain in gains.items() if j not in none},
        gain=finding.evidence.gain - sum(gains.get(j, 0.0) for j in none))
    return replace(finding, joints=tuple(j for j in finding.joints if j not in none),
                   evidence=evidence,
                   parameters={name: value for name, value in finding.parameters.items()
                               if not any(name.endswith(f' ({joint})') for joint in none)})


def _faint(model, better, trace, chosen):
    # A delay moves all that its joint does, not only what the old model knew of, and of presliding
    # the travel is new.
    if chosen.name not in EFFECTS or EFFECTS[chosen.name].whole_arm \
            or chosen.name in (LATE, PRESLIDING):
        return False
    old, new = ({(use.name, use.joint): (use.formula, m.mean[where])
                 for use, where in m.slices()} for m in (model, better))
    parts = []
    for hypothesis, score in chosen.parts:
        shape, mean = new[hypothesis.name, hypothesis.joint]
        before, start = old.get((hypothesis.name, hypothesis.joint), (shape, 0.0))
        if shape != before:
            # What the model had with another shape: the figures are no change of those.
            return False
        parts.append((hypothesis, replace(score, theta=(mean - start) / hypothesis.scale)))
    return not trace.matters(replace(chosen, parts=tuple(parts)))
