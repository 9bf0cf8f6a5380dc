"""What the trace found, in the words and numbers of a Diagnosis."""

from dataclasses import replace

import numpy as np

from ..effects import EFFECTS, LATE, LINK_INERTIA, PRESLIDING
from ..effects.knee import KNEE
from ..identification.turning_fit import PEAK
from .change_of import change_covariance
from .diagnosis import Alternative, CONFIRMED, Evidence, Finding, SUSPECTED, UNKNOWN
from .doubts.limits import LEAST_WARMING
from .doubts.unknown import left_over
from .pictures import picture
from .tracing.candidate import ahead, hypotheses_of, significant
from .tracing.confusable import advice, NO_MOTION
from .tracing.effort_filter import filtered_instead
from .tracing.gap_doubt import GAP, gap_doubt
from .tracing.hypotheses import ONE_CAUSE
from .tracing.one_torque import is_its_link, OF_A_LINK, weight_is_its_own
from .tracing.shape_doubt import NO_DOUBT, shape_doubt

_MOST_PICTURES = 3
# What a load that nobody declared is called among the alternatives.
UNDECLARED_LOAD = 'undeclared_load'
# At one temperature, which parameters are not stated at, an effect is as its change with it.
_WITH_WARMTH = {'coulomb_friction': 'temperature_dependent_coulomb_friction',
                'viscous_friction': 'temperature_dependent_viscous_friction',
                'torque_scale': 'torque_scale_temperature'}
# A model is worse at a joint where the error of recordings kept for the test grows by this factor.
_WORSE = 1.02
_DRAWS = 400  # for the spread of parameters that are functions of the fitted ones


def findings_of(model, better, trace, odd=()):
    """
    Return the Findings of a finished Trace.

    odd: joints with something unknown, where no effect is confirmed, and only there what has no
    name.
    """
    found = []
    for step in trace.steps:
        blocks = trace.beside(step)
        found.append(_finding((model, better), trace, step, blocks, odd,
                              _doubts_by_joint(step.chosen, blocks, model, trace.residual)))
    return tuple(found)


def _doubts_by_joint(candidate, blocks, model, residual):
    """Return {joint index: ShapeDoubt} of what was searched."""
    found = {}
    for hypothesis in hypotheses_of(candidate):
        if hypothesis.shape and KNEE.name not in hypothesis.shape:
            of = gap_doubt if hypothesis.name == GAP else shape_doubt
            doubt = of(hypothesis, blocks, model, residual)
            found |= dict.fromkeys(hypothesis.columns, doubt)
    return found


def _finding(models, trace, step, blocks, odd, searched):
    (model, better), chosen, residual = models, step.chosen, trace.residual
    robot = model.robot
    torque = chosen.torque(robot.n)
    # What else was fitted is fitted again without the effect, and beside it.
    without = left_over(robot, trace.without(step))
    partial = np.stack([blocks.left_over(j, torque[:, j]) for j in range(robot.n)], axis=1)
    main = max(chosen.touched, key=lambda j: sum(
        score.by_joint.get(j, 0.0) for _, score in chosen.parts))
    sure = significant(chosen) and (chosen.name == UNKNOWN) == (main in odd) \
        and not any(step is doubted for doubted in trace.maybe_soft_ends)
    alternatives = alternatives_of(robot, residual, step)
    filtered = filtered_instead(robot, chosen, blocks, residual) if chosen.name == LATE else ()
    return Finding(
        chosen.name, _joints(robot, chosen),
        _parameters(model, better, chosen, searched),
        _explained(without, partial - torque, residual.weights),
        _evidence(robot.joints, trace, step, torque), (*alternatives, *filtered),
        separating_motion(
            robot, residual, chosen,
            [a.name for a in step.alternatives if a.joints != chosen.joints],
            [a.name for a in (*(a for a in step.alternatives if a.joints == chosen.joints),
                              *filtered)]),
        trace.declared(chosen), CONFIRMED if sure else SUSPECTED,
        _pictures(robot, residual, partial, chosen),
        (chosen.variable,) if chosen.name == UNKNOWN else ())


def _joints(robot, candidate):
    """Return the names of the joints a Candidate stands for; a leaning base is all joints'."""
    whole = candidate.name in EFFECTS and EFFECTS[candidate.name].whole_arm
    return tuple(robot.joints[j] for j in (range(robot.n) if whole else candidate.joints))


def alternatives_of(robot, residual, step):
    """Return the Alternatives of a Step: what the recordings, or no motion, can tell from it."""
    found = [Alternative(other.name, _joints(robot, other), less.gain, less.std)
             for other in step.alternatives for less in [ahead(step.chosen, other)]]
    # What is the same torque the choice did not ask for, and no block could tell.
    joints = _joints(robot, step.chosen)
    same = [(name, joints) for name in _of_its_link(robot, residual, step.chosen)
            if name not in {a.name for a in found if a.joints == joints}]
    same += [(UNDECLARED_LOAD, _joints(robot, step.chosen))] * _is_last_link(robot, step.chosen)
    same += [(name, _joints(robot, step.chosen)) for name in _by_warmth(residual, step.chosen)]
    return (*(Alternative(name, joints, 0.0, 0.0) for name, joints in same), *found)


def _by_warmth(residual, chosen):
    """Return the names of what a joint of one temperature shows alike: a change with it."""
    # Where it is not known it counts as 0.
    known = [column[column != 0.0] for column in residual.x.warmth[:, chosen.joints].T]
    alike = all(len(column) and np.ptp(column) < LEAST_WARMING
                and abs(column.mean()) >= LEAST_WARMING for column in known)
    return [_WITH_WARMTH[chosen.name]] if chosen.name in _WITH_WARMTH and alike else []


def refuted(findings, joints, before, after, without):
    """
    Return (Findings, sentences): suspected is what made its joint worse where nothing was fitted.

    joints: names (n,); before, after (n,) [Nm]: errors on recordings kept for the test;
    without(k): those (n,) of a model identified likewise without finding k, and, on the same rows,
    with it: what estimating everything else again has made worse is no effect's fault. The better
    model keeps the effect: recordings that chose would be none to test on any more.
    """
    worse = {name: (old, new) for name, old, new in zip(joints, before, after)
             if new > _WORSE * old}
    kept, told = [], {}
    for k, finding in enumerate(findings):
        asked = worse.keys() & _answering(finding, joints)
        if finding.verdict == CONFIRMED and not finding.recording and asked \
                and finding.name != UNKNOWN:
            others = without(k)
            for name in sorted(asked, key=list(joints).index):
                less, beside = (errors[joints.index(name)] for errors in others)
                if beside <= _WORSE * less:
                    continue
                finding = replace(finding, verdict=SUSPECTED)
                told[name] = (*told.get(name, ()), (
                    f'{name}: {finding.name} is only suspected, because the error on what was '
                    f'kept for the test rose from {worse[name][0]:.3g} to {worse[name][1]:.3g} Nm '
                    f'({less:.3g} Nm without it)'))
        kept.append(finding)
    return tuple(kept), (*(_also_worse(name, *worse[name], kept) for name in worse
                           if name not in told), *(text for texts in told.values()
                                                   for text in texts))


def _also_worse(name, old, new, findings):
    """Return the sentence on a joint that became worse, but is no finding's main one."""
    there = [f.name for f in findings if f.verdict == CONFIRMED and not f.recording
             and name in f.joints]
    why = f'though {" and ".join(there)} was found there too' if there else \
        'though nothing confirmed acts there: everything is estimated together'
    return (f'{name}: the error on what was kept for the test rose from {old:.3g} to {new:.3g} '
            f'Nm, {why}')


def _answering(finding, joints):
    """Return the names of joints that must not become worse by a Finding: all of one cause."""
    return set(finding.joints) if finding.name in ONE_CAUSE \
        else {joints[finding.main_joint(joints)]}


def _evidence(joints, trace, step, torque):
    rms = float(np.sqrt(np.mean(torque ** 2, axis=0)).max())
    chosen, rival = step.chosen, step.next_best
    by_joint = dict.fromkeys(chosen.touched, 0.0)
    for _, score in chosen.parts:
        for j, gain in score.by_joint.items():
            by_joint[j] += float(gain)
    return Evidence(float(chosen.gain), float(chosen.std), float(step.needed),
                    trace.residual.observations, trace.trials, rms, rival and rival.name,
                    rival and float(chosen.gain - rival.gain),
                    {joints[j]: gain for j, gain in by_joint.items()}, step.next_possible)


def separating_motion(robot, residual, chosen, elsewhere, here=()):
    """
    Return in words the motion that tells a Candidate from its alternatives, or ''.

    elsewhere, here: names of those on other joints, and on its own.
    """
    if chosen.name == UNKNOWN:
        return (f'the residual follows {chosen.variable}; move the joint so that '
                f'{chosen.variable} covers its range while everything else stays the same')
    same = _of_its_link(robot, residual, chosen, here)
    others = [*_by_warmth(residual, chosen), *elsewhere,
              *(name for name in here if name not in same)]
    own_weight = len(chosen.joints) == 1 and weight_is_its_own(robot, chosen.joints[0])
    told = [advice(chosen.name, others, own_weight)]
    if same:
        names = ' and '.join(dict.fromkeys((chosen.name, *same)))
        told.insert(0, f'{NO_MOTION} {names} here: the link\'s weight across the axis of its '
                    'joint pulls as a spring, its inertia about it as a rotor; the model holds '
                    'the sum; another mounting, or weighing the link, tells')
    if _is_last_link(robot, chosen):
        told.insert(0, f'{NO_MOTION} it from a load in the hand other than declared: take '
                    'everything off the hand, or declare what is there (load.yaml)')
    return '; '.join(filter(None, told))


def _is_last_link(robot, chosen):
    """Tell whether a Candidate is the link that carries the load, which asks for the same."""
    return chosen.name == LINK_INERTIA.name and robot.n - 1 in chosen.joints


def _of_its_link(robot, residual, chosen, alternatives=()):
    """
    Return the names of what no motion can tell a Candidate of one joint from.

    alternatives: names that recordings do not tell it from; a link is asked about these only.
    """
    if len(chosen.joints) != 1 or chosen.common:
        return []
    joint, = chosen.joints
    if chosen.name == LINK_INERTIA.name:
        return [name for name in OF_A_LINK if name in alternatives
                and is_its_link(name, joint, robot, residual.x)]
    alike = chosen.name in OF_A_LINK and is_its_link(chosen.name, joint, robot, residual.x)
    return [LINK_INERTIA.name] * alike


def _explained(without, left, weights):
    """Return the share (n,) of the variance left without an effect that goes with it."""
    # At rest friction hides everything: such rows weigh little.
    before, after = ((weights * values ** 2).sum(axis=0) for values in (without, left))
    return np.clip((before - after) / np.maximum(before, 1e-12), 0.0, 1.0)


def _pictures(robot, residual, partial, chosen):
    drawn = []
    for hypothesis, score in chosen.parts:
        joint = max(hypothesis.columns, key=lambda j: score.by_joint.get(j, 0.0))
        drawn.append(picture(robot, residual, partial[:, joint], hypothesis, score, joint))
    return tuple(p for p in drawn if p is not None)[:_MOST_PICTURES]


def _parameters(model, better, chosen, searched):
    """Return {name: (mean, std, unit)}: figures of the better model, and changes of old ones."""
    if chosen.name == UNKNOWN:
        return {}
    out = {}
    for hypothesis, _ in chosen.parts:
        joint = '' if len(chosen.parts) == 1 else f' ({model.robot.joints[hypothesis.joint]})'
        values = _of_link(model, better, hypothesis) if chosen.name == 'link_inertia' \
            else _of_effect(model, better, hypothesis, searched.get(hypothesis.joint, NO_DOUBT))
        out |= {name + joint: value for name, value in values.items()}
    if chosen.name == 'base_tilt':
        # What is to stand in the robot file: the angles turn gravity, the base leans against it.
        gravity = better.robot.turned_gravity(better.layout.tilt(better.mean))
        out |= {f'gravity_{axis}': (value, np.nan, 'm/s^2')
                for axis, value in zip('xyz', gravity)}
    return out


def _of_link(model, better, hypothesis):
    where = np.arange(10 * hypothesis.joint, 10 * hypothesis.joint + 10)
    change = better.mean[where] - model.mean[where]
    std = np.sqrt(np.diag(change_covariance(model, better, where, where)))
    return {name: (change[k], std[k], unit)
            for k, (name, unit) in enumerate(LINK_INERTIA.parameters)}


def _of_effect(model, better, hypothesis, searched):
    effect = EFFECTS[hypothesis.name]
    new, old = _slice(better, hypothesis), _slice(model, hypothesis)
    if new is None:
        return {}
    use, where = new
    mean, covariance = better.mean[where], better.covariance[where, where]
    variance = np.diag(covariance)
    # Share and shift of a delay are one quantity: the share is that of the shift as it stands.
    if hypothesis.name != LATE:
        variance = variance + np.diag(searched.of_parameters)
    std = np.sqrt(variance)
    # Of presliding the travel tells; its level is what else turns, hardly anything.
    names = () if hypothesis.name == PRESLIDING else effect.parameters
    out = {name: (mean[k], std[k], unit) for k, (name, unit) in enumerate(names)}
    # A share of another delay, a peak at another velocity is no change of the old one.
    if old is not None and old[0].formula == use.formula:
        places = (np.arange(part.start, part.stop) for part in (old[1], where))
        of_change = np.diag(change_covariance(model, better, *places)) + variance - np.diag(
            covariance)
        out |= {f'change_of_{name}': (mean[k] - model.mean[old[1]][k], np.sqrt(of_change[k]), unit)
                for k, (name, unit) in enumerate(names)}
    if effect.derived:
        # What a period does to sine and cosine turns them, and leaves their amplitude.
        out |= _derived(effect, use.shape, mean, covariance)
    # A knee is estimated with the parameters, any other shape was searched: now, or once before.
    std = {**use.shape_std, **searched.std}
    if hypothesis.name in (PRESLIDING, PEAK):
        # They have settled beside everything else since then (turning_fit.py).
        moved = {name: value - hypothesis.shape[name] for name, value in use.told_shape.items()}
        std = {name: np.hypot(std.get(name, 0.0), way) for name, way in moved.items()
               if np.isfinite(way)}
    return out | {s.name: (use.told_shape[s.name], std.get(s.name, np.nan), s.unit)
                  for s in effect.shapes if s.name in use.told_shape}


def _slice(model, hypothesis):
    for use, where in model.slices():
        if use.name == hypothesis.name and use.joint == hypothesis.joint:
            return use, where
    return None


def _derived(effect, shape, mean, covariance):
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, _DRAWS)
    made = effect.derived(mean, shape)
    spread = [effect.derived(draw, shape) for draw in draws]
    return {name: (value, _spread([s[name][0] - value for s in spread], unit), unit)
            for name, (value, unit) in made.items()}


def _spread(errors, unit):
    """Return the standard deviation of errors; an angle comes round after a turn."""
    if unit == 'rad':
        errors = np.angle(np.exp(1j * np.array(errors)))
    return float(np.std(errors))
