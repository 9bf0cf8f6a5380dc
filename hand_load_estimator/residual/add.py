"""Add what was found: a torque model with the new effects, everything in it estimated together."""

from dataclasses import replace

import numpy as np

from ..effects import LATE, PRESLIDING
from ..identification.evidence import between_gaps
from ..identification.identify import prior
from ..identification.knee_fit import with_knees_fitted
from ..identification.left_out_noise import noise_left_out
from ..identification.load_agreement import share_left_out
from ..identification.regression_system import held_out, System
from ..identification.residual_noise import (known_joints, rmse_of, sliding_left,
                                             with_usual_drift)
from ..identification.turning_fit import PEAK, with_turning_fitted
from ..torque.columns import ColumnLayout, effect_slices
from ..torque.sliding import moved_joints
from ..torque_model import TorqueModel
from .diagnosis import UNKNOWN
from .doubts.known_recordings import made_from
from .measured.find import declared_delays
from .tracing.confusable import partners
from .tracing.hypotheses import with_effect
from .tracing.hypothesis import DOUBTFUL, EFFECT_FACTOR, LINK_FACTOR

# What is known of the arm from before stays known, with standard deviations so much wider; of
# joints that the recordings do not move, as it was.
WIDER = 3.0
# Of the old model's residual density at least this share stays stated, where it saw a joint move.
SHOWN = 0.5
# Rounds of estimating parameters and what depends on them.
TURNS = 3
# A variance so small is none.
NONE = 1e-12


def better_model(model, steps, evidence):
    """
    Return the TorqueModel with the effects of steps, identified from Evidence.

    The old model's mean and covariance are the prior (eq. 11), except where all recordings are
    among those it was made from: then the robot file's. An `unknown` effect adds nothing.
    """
    uses, delays = model.uses, declared_delays(model)
    changed, together = set(), set()
    for step in steps:
        if step.chosen.common and step.chosen.name == LATE:
            together.update(step.chosen.joints)
        for hypothesis, _ in step.chosen.parts:
            if hypothesis.name in (UNKNOWN, 'link_inertia'):
                changed.add((hypothesis.name, hypothesis.joint))
                continue
            uses = with_effect(uses, hypothesis, delays)
            changed.add((hypothesis.name, hypothesis.joint))
            changed |= perhaps_too(model, step, hypothesis)
    return identified_again(model, uses, evidence, changed, together)


def perhaps_too(model, step, hypothesis):
    """Return (name, joint) of declared effects that may have changed as well as, or instead."""
    alike = {other.name for other in step.alternatives if hypothesis.joint in other.joints}
    return {(u.name, u.joint) for u in model.uses if u.joint == hypothesis.joint
            and u.name in alike & set(partners(hypothesis.name))}


def identified_again(model, uses, evidence, changed=frozenset(), together=frozenset()):
    """
    Return the TorqueModel with other uses, identified from Evidence.

    changed: (name, joint) of declared effects that the old figures no longer hold for; together:
    joints of one delay, whose `shift` stays one; the shares of each are estimated.
    """
    evidence = between_gaps(evidence)
    own = made_from(model, evidence)
    known = np.isfinite(np.concatenate([e.motion.temperature for e in evidence])).any(axis=0)
    mean, covariance = _prior(model, uses, changed, own, (moved_joints(evidence), known))
    links = _links_declared(model, changed)
    turning = tuple(sorted({joint for name, joint in changed if name in names})
                    for names in ((PRESLIDING, PEAK), (PEAK,)))
    return _identified(model, (uses, links, together, turning), (mean, covariance), evidence, own)


def _prior(model, uses, changed, own, told):
    robot, (moved, known) = model.robot, told
    links = _links_declared(model, changed)
    first, wide = prior(robot, uses, links, known)
    if own:
        return first, _widened(wide, robot, uses, changed)
    mean, covariance = first.copy(), np.zeros_like(wide)
    old = {(use.name, use.joint): where for use, where in model.slices()}
    rows, places = list(range(10 * robot.n)), list(range(10 * robot.n))
    new = TorqueModel(robot, uses, links, first, wide, model.residuals)
    for use, where in new.slices():
        if (use.name, use.joint) in old:
            rows += range(where.start, where.stop)
            before = old[use.name, use.joint]
            places += range(before.start, before.stop)
    mean[rows] = model.mean[places]
    wider = np.full(len(rows), WIDER)
    for use, where in new.slices():
        if not moved[use.joint]:
            wider[np.isin(rows, np.arange(where.start, where.stop))] = 1.0
    covariance[np.ix_(rows, rows)] = np.outer(wider, wider) * model.covariance[
        np.ix_(places, places)]
    mean, covariance = _of_shifts(mean, covariance, robot.n, model.uses, uses)
    wide = np.diag(wide)
    for use, where in new.slices():
        free = (use.name, use.joint) in changed or (use.name, use.joint) not in old
        if free:
            covariance[where, where] += np.diag(EFFECT_FACTOR ** 2 * wide[where])
    for name, joint in changed:
        if name == 'link_inertia':
            where = slice(10 * joint, 10 * joint + 10)
            covariance[where, where] += np.diag(EFFECT_FACTOR ** 2 * wide[where])
    return mean, covariance


def _links_declared(model, changed):
    return model.links_declared or any(name == 'link_inertia' for name, _ in changed)


def _widened(covariance, robot, uses, changed):
    """Return the robot file's prior, as wide for what was found as the search allowed."""
    variance = np.diag(covariance).copy()
    for use, where in effect_slices(robot.n, uses):
        if (use.name, use.joint) in changed:
            variance[where] *= EFFECT_FACTOR ** 2
    for name, joint in changed:
        if name == 'link_inertia':
            variance[10 * joint:10 * joint + 10] *= LINK_FACTOR ** 2
    return np.diag(variance)


def _before(use, own):
    """Return the use with what is known of its knee when it is identified again."""
    return replace(use, shape_std={} if own else {name: WIDER * std for name, std
                                                  in use.shape_std.items()})


def _of_shifts(mean, covariance, n, before, uses):
    """Return mean (P,) and covariance of delays' shares with other shifts: the same delays."""
    shifts = {use.joint: use.shape['shift'] for use in before if use.name == LATE}
    factor = np.ones(len(mean))
    for use, where in effect_slices(n, uses):
        if use.name == LATE and use.joint in shifts:
            factor[where] = shifts[use.joint] / use.shape['shift']
    return factor * mean, np.outer(factor, factor) * covariance


def _with_whole_delays(n, uses, together, x, covariance):
    """
    Return uses and x (P,) with the delays that make each share a whole one.

    A share of nothing is that of a delay nobody has estimated; half of one or less stays. Joints
    (indices) that are late together keep one delay.
    """
    uses, x, groups = list(uses), x.copy(), {}
    for k, (use, where) in enumerate(effect_slices(n, uses)):
        if use.name == LATE:
            own = None if use.joint in together else use.joint
            groups.setdefault((own, use.shape['shift']), []).append((k, where.start))
    for (_, shift), those in groups.items():
        numbers = [number for _, number in those]
        variance = np.maximum(np.diag(covariance)[numbers], NONE)
        share = np.average(x[numbers], weights=1.0 / variance)
        # More than a whole is a longer delay.
        if share and share < 1.0 - DOUBTFUL:
            continue
        x[numbers] = 1.0
        for k, _ in those if share else ():
            uses[k] = replace(uses[k], shape={'shift': float(shift * share)})
    return tuple(uses), x


def _identified(model, declared, before, evidence, own):
    (asked, links, together, turning), (mean, covariance) = declared, before
    known = tuple(_before(use, own) for use in asked)
    robot, residuals = model.robot, model.residuals
    # From a share of nothing the first turn would take a delay for something else.
    uses, x = _with_whole_delays(robot.n, asked, together, mean, covariance)
    mean, covariance = _of_shifts(*before, robot.n, asked, uses)
    intensity, friction, moved = (residuals.intensity, model.held_friction(),
                                  moved_joints(evidence))
    drift = residuals.drift
    system, torque_bound = None, ColumnLayout(robot.n, uses).needs
    for turn in range(TURNS):
        # Only effects that depend on torques change their columns with x, and travels all.
        if system is None or torque_bound or not system.levels_hold(uses, x):
            system = System(robot, uses, evidence, x)
        weights = system.weights(intensity, friction)
        uses, x, posterior = with_knees_fitted(system.with_drift(drift), uses, known, mean,
                                               covariance, weights)
        unjudged = TorqueModel(robot, uses, links, x, posterior, None)
        friction = unjudged.held_friction()
        intensity, drift = noise_left_out(system, (mean, covariance), weights, friction)
        if not own:
            # New recordings need not show all that the old ones did.
            drift = np.maximum(drift, residuals.drift)
            intensity = np.maximum(intensity, _still_stated(residuals, moved)
                                   * residuals.intensity)
        if turn == 0 and turning[0]:
            uses, system = with_turning_fitted(system, uses, evidence, x, intensity,
                                               *turning), None
        if turn < TURNS - 1:
            uses, x = _with_whole_delays(robot.n, uses, together, x, posterior)
            mean, covariance = _of_shifts(*before, robot.n, asked, uses)
    system, stated = system.with_drift(drift), system.weights(intensity, friction)
    uses, x, posterior = with_knees_fitted(system, uses, known, mean, covariance, stated)
    left_out = held_out(system, mean, covariance, stated)
    unjudged = TorqueModel(robot, uses, links, x, posterior, None)
    share = share_left_out(system, left_out, stated, drift)
    found = replace(_residuals(unjudged, residuals, (system, left_out, drift), evidence, own),
                    intensity=intensity, load_share=share, sliding=sliding_left(system, left_out))
    seen = np.concatenate([e.motion.temperature.ravel() for e in evidence])
    seen = seen[np.isfinite(seen)]
    spans = (model.temperatures, (seen.min(), seen.max()) if len(seen) else None)
    temperatures = [span for span in spans if span is not None]
    marks = tuple(dict.fromkeys((*model.recordings, *(e.mark for e in evidence))))
    return TorqueModel(robot, uses, links, x, posterior, found, marks,
                       (float(min(t[0] for t in temperatures)),
                        float(max(t[1] for t in temperatures))) if temperatures else None)


def _residuals(model, old, fit, evidence, own):
    """
    Return Residuals whose density, share and residual while sliding are still the old.

    model: as identified by the fit, a System, its LeftOut and its drift; old: the model's before.
    """
    (system, left_out, drift), moved = fit, moved_joints(evidence)
    rmse = rmse_of(model, system, left_out.residual, moved)
    if own:
        drift = with_usual_drift(model, system, drift, known_joints(evidence))
        return replace(old, rmse=rmse, unmoved=~moved, drift=drift)
    still = np.sqrt(_still_stated(old, moved)) * old.rmse
    rmse = np.where(moved, np.maximum(rmse, still), old.rmse)
    unmoved = None if old.unmoved is None else old.unmoved & ~moved
    return replace(old, rmse=rmse, unmoved=unmoved, drift=drift)


def _still_stated(old, moved):
    """
    Return the share (n,) of the old Residuals' density that stays stated whatever is left now.

    Of a joint that had never moved they state what may be left of friction nobody had seen.
    """
    unseen = np.zeros(len(moved), dtype=bool) if old.unmoved is None else old.unmoved
    return np.where(~moved, 1.0, np.where(unseen, 0.0, SHOWN))
