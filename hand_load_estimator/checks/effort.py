"""Is the effort what the robot file says: unit, sign, gravity, delay, compensation, saturation."""

from dataclasses import replace

import numpy as np

from .effort_beyond import check_beyond
from .effort_fit import CERTAIN, fit_delay, fit_joint
from .effort_range import check_range
from .effort_terms import joint_columns, rigid_terms
from .finding import DOUBT, Finding, OK, UNKNOWN, WRONG
from .gravity_fit import fit_gravity
from .load_fit import fit_load

_RECORD = 'record a motion of `hand_load excite`'
# Nominal link masses of a URDF and an unknown load stay within it; amperes for Nm do not.
_LIKELY_GAIN = (0.6, 1.6)
_POSSIBLE_GAIN = (0.33, 3.0)
# Share of max_velocity: below it friction's slow build-up after a reversal looks like a delay.
_QUICK = 0.05
_TILT_OK, _TILT_DOUBT = np.radians([5.0, 15.0])


def check_effort(signals, robot, load):
    """
    Return findings and a table {joint: {...}} about the effort.

    signals: Signals whose effort is torque by the robot file's constants [Nm]; load: the
    LoadParameters known to be in the hand, or None.
    """
    terms = rigid_terms(robot, signals, load)
    # What has been reported has range and size; the rest is about the whole torque.
    ends, left_out = check_range(signals, robot)
    beyond = check_beyond(signals, terms, robot)
    signals = replace(signals, effort=signals.effort
                      + np.array([robot.configured_torque(q) for q in signals.q]))
    columns = joint_columns(signals, terms)
    # Of what is cut off a fit makes another gain.
    moving = [j for j, c in enumerate(columns) if c is not None and j not in left_out]
    if not moving:
        unit = beyond if left_out else beyond or _standing(signals, terms, robot)
        return [*filter(None, [unit]), *ends], {}
    gravity = np.array(robot.file.gravity)
    fits = {j: fit_joint(columns[j], gravity) for j in moving}
    direction = _oriented(fit_gravity([columns[j] for j in moving], gravity,
                                      np.mean([f.spread for f in fits.values()])), fits, robot)
    unit = _unit(fits, robot, load)
    if beyond and unit.verdict != WRONG:
        unit = beyond
    findings = [unit, _sign(fits, robot), _compensation(fits),
                _gravity(direction, robot), _delay(signals, terms, gravity, _told(fits), robot),
                *ends]
    told = _told(fits)
    if told and _POSSIBLE_GAIN[0] <= _typical(told).gain <= _POSSIBLE_GAIN[1]:
        findings.append(_load(signals, robot, moving, load))
    return findings, {robot.joints[j]: _row(fit) for j, fit in fits.items()}


def _row(fit):
    names = ('friction', 'friction_std', 'r2', 'residual', 'gravity_rms', 'rigid_rms')
    gain = {'gain': float(fit.gain), 'gain_std': float(fit.gain_std)} if fit.told else {
        'gain': None, 'gain_std': None}
    return {**gain, **{name: float(getattr(fit, name)) for name in names}}


def _has_friction(robot):
    return robot.effort.kind != 'link_torque'


def _told(fits):
    return {j: fit for j, fit in fits.items() if fit.told}


def _standing(signals, terms, robot):
    """Compare effort and gravity of a standing arm: friction blurs it, a wrong unit shows."""
    expected = (terms.gravity @ np.array(robot.file.gravity)).mean(axis=0)
    measured = signals.effort.mean(axis=0)
    ratio = measured @ expected / max(expected @ expected, 1e-12)
    text = (f'the arm stands; effort is {ratio:.2f} times the torque of gravity, which static '
            'friction blurs')
    if np.linalg.norm(expected) < 0.02 * np.linalg.norm(robot.limits.torque):
        return Finding('effort unit', UNKNOWN, 'the arm stands where gravity hardly acts', _RECORD)
    if not _LIKELY_GAIN[0] / 1.5 < ratio < _LIKELY_GAIN[1] * 1.5:
        return Finding('effort unit', DOUBT, text, _RECORD)
    return Finding('effort unit', UNKNOWN, f'{text}; nothing speaks against the robot file',
                   _RECORD)


def _typical(told):
    """Return the JointFit with the median gain, weighted with the gravity that joints carry."""
    ordered = sorted(told.values(), key=lambda f: f.gain)
    weights = np.array([f.gravity_rms for f in ordered]) + 1e-9
    return ordered[np.searchsorted(np.cumsum(weights), 0.5 * weights.sum())]


def _unit(fits, robot, load):
    told = _told(fits)
    if not told:
        return Finding('effort unit', UNKNOWN, 'no joint moves enough against its weight', _RECORD)
    typical = _typical(told)
    gain = typical.gain
    kind = robot.effort.kind
    text = (f'{gain:.2f} times the torque of the robot file\'s rigid body '
            f'({", ".join(f"{robot.joints[j]} {f.gain:.2f}" for j, f in told.items())})')
    if _LIKELY_GAIN[0] <= abs(gain) <= _LIKELY_GAIN[1]:
        return _likely_unit(told, robot, load, text)
    if _POSSIBLE_GAIN[0] <= abs(gain) <= _POSSIBLE_GAIN[1]:
        return Finding('effort unit', DOUBT, text, 'state the load in load.yaml; compare link '
                       'masses of the URDF and torque constants')
    todo = 'compare effort.kind and torque_constants with the driver'
    if abs(gain) <= CERTAIN * typical.gain_std:
        todo += '; the effort has next to nothing of the rigid body in it (see compensation)'
    elif kind != 'motor_current' and abs(gain) < _POSSIBLE_GAIN[0]:
        todo = (f'looks like amperes: kind motor_current with about {1.0 / gain:.1f} Nm/A; '
                'or the effort has no gravity in it (see compensation)')
    elif kind == 'motor_current' and abs(gain) > _POSSIBLE_GAIN[1]:
        todo = 'looks like Nm already: try kind motor_torque'
    return Finding('effort unit', _if_several(told), text, todo)


def _if_several(joints):
    """Return wrong, or doubt when one joint alone says it: it may have a balancer."""
    return WRONG if len(joints) > 1 else DOUBT


def _likely_unit(told, robot, load, text):
    apart = [robot.joints[j] for j, f in told.items()
             if not _LIKELY_GAIN[0] <= f.gain <= _LIKELY_GAIN[1]
             and not abs(f.gain - 1.0) < CERTAIN * f.gain_std]
    if not apart:
        return Finding('effort unit', OK, text)
    why = ('link masses of the URDF or torque constants' if load is not None else
           'a load in the hand that no load.yaml states, link masses of the URDF or torque '
           'constants')
    return Finding('effort unit', DOUBT, f'{text}; {", ".join(apart)} apart from the others',
                   f'compare {why}')


def _sign(fits, robot):
    if not _has_friction(robot):
        negative = [j for j, f in _told(fits).items() if f.gain < -CERTAIN * f.gain_std]
        names = ', '.join(robot.joints[j] for j in negative)
        if negative:
            return Finding('effort sign', WRONG, f'against the rigid body on {names}',
                           'effort must be positive along +q')
        return Finding('effort sign', OK if _told(fits) else UNKNOWN,
                       'positive along +q where it can be told')
    driving = [robot.joints[j] for j, f in fits.items() if f.braking < 0]
    if driving:
        return Finding('effort sign', WRONG, f'friction pushes along the motion on '
                       f'{", ".join(driving)}', 'reverse the effort of these joints: negative '
                       'torque_constants, or a sign in the driver')
    against = [robot.joints[j] for j, f in _told(fits).items()
               if f.gain < -CERTAIN * f.gain_std]
    unsure = [robot.joints[j] for j, f in fits.items() if f.braking == 0]
    if against:
        return Finding('effort sign', DOUBT, f'friction brakes as it should, but gravity pulls '
                       f'the other way on {", ".join(against)}', 'a balancer, a heavy load, or '
                       'the direction of gravity or of a joint axis')
    if unsure:
        return Finding('effort sign', UNKNOWN, f'not certain on {", ".join(unsure)}', _RECORD)
    return Finding('effort sign', OK, f'friction brakes on all {len(fits)} moving joints')


def _compensation(fits):
    """Tell whether gravity has been taken off the effort."""
    sure = [f for f in fits.values() if f.gravity_gain_std < 0.1 and f.gravity_rms > f.residual]
    if not sure:
        return Finding('compensation', UNKNOWN, 'gravity torque changes too little', _RECORD)
    weights = np.array([f.gravity_rms for f in sure])
    gain = np.average([f.gravity_gain for f in sure], weights=weights)
    certain = abs(gain) > CERTAIN * max(f.gravity_gain_std for f in sure)
    if abs(gain) < 0.1 and not certain:
        return Finding('compensation', _if_several(sure), f'the effort shows {gain:.2f} of the '
                       f'arm\'s weight on {len(sure)} joints: gravity has been taken off, or a '
                       'balancer carries it', 'have the driver publish the whole torque')
    return Finding('compensation', OK, f'the effort shows gravity ({gain:.2f} of the arm\'s '
                   'weight)')


def _oriented(direction, fits, robot):
    """Return the GravityFit with the sign the friction (else a positive gain) asks for."""
    vote = 0.0
    for gain, fit in zip(direction.gains, fits.values()):
        sense = fit.braking if _has_friction(robot) and fit.braking else 1
        vote += fit.told * sense * np.sign(gain) * fit.gravity_rms
    sign = 1.0 if vote >= 0.0 else -1.0
    return type(direction)(sign * direction.vector, direction.std, sign * direction.gains,
                           direction.improvement)


def _gravity(direction, robot):
    told = np.array(robot.file.gravity)
    cosine = direction.vector @ told / (np.linalg.norm(direction.vector) * np.linalg.norm(told))
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    if not direction.std < np.radians(10.0):
        return Finding('gravity', UNKNOWN, 'the motion does not tell its direction', _RECORD)
    text = (f'{np.degrees(angle):.1f} +- {np.degrees(direction.std):.1f} deg from the robot '
            'file\'s direction, fitted ['
            + ', '.join(f'{g:.2f}' for g in direction.vector) + ']')
    if angle <= max(_TILT_OK, 3.0 * direction.std):
        return Finding('gravity', OK, text)
    reversed_only = angle > np.pi - _TILT_DOUBT
    if direction.improvement < 0.1 and not reversed_only:
        return Finding('gravity', UNKNOWN, f'{text}; the robot file\'s direction fits as well',
                       _RECORD)
    if angle <= _TILT_DOUBT:
        return Finding('gravity', DOUBT, text, 'level the base or correct `gravity`; wrong link '
                       'masses look alike')
    return Finding('gravity', WRONG, text, 'set `gravity` in the robot file to how the arm is '
                   'mounted')


def _delay(signals, terms, gravity, told, robot):
    slowest = _QUICK * robot.limits.velocity
    columns = joint_columns(signals, terms, slowest=slowest)
    quick = [j for j in told if columns[j] is not None and fit_joint(columns[j], gravity).told]
    if not quick:
        return Finding('delay', UNKNOWN, 'no joint moves enough against its weight while it is '
                       f'faster than {100.0 * _QUICK:g} % of its max_velocity (slower, friction '
                       'that builds up looks like a delay)', 'record a quicker motion of '
                       '`hand_load excite`')
    delay, std = fit_delay(signals, terms, gravity, quick, slowest)
    if not std < 0.012:
        return Finding('delay', UNKNOWN, 'reversals are too few or too slow to tell', _RECORD)
    text = f'effort {1e3 * delay:+.1f} +- {1e3 * std:.1f} ms late against the position'
    if robot.file.command_lag is not None:
        delay -= robot.file.command_lag
        text += f', {1e3 * delay:+.1f} ms beyond the lag of the robot file'
    allowed = max(0.015, 1.5 / signals.rate, 3.0 * std)
    if abs(delay) <= allowed:
        return Finding('delay', OK, text)
    return Finding('delay', DOUBT if abs(delay) < 0.05 else WRONG, text, 'stamp position and '
                   'effort together; a filter on one of them delays it; commanded positions need '
                   '`position` in the robot file')


def _load(signals, robot, moving, load):
    """Compare the load the effort looks like with the stated one."""
    fit = fit_load(signals, robot, rigid_terms(robot, signals), moving)
    rated = robot.rated_load.mass
    if not fit.std < 0.1 * rated:
        return Finding('load', UNKNOWN, 'the motion does not show a load', _RECORD)
    stated = 'none is stated' if load is None else f'stated: {load.mass:g} kg'
    text = (f'the effort looks like {fit.mass:.2f} +- {fit.std:.2f} kg in the hand, wrong link '
            f'masses included; {stated}')
    expected = load.mass if load is not None else 0.0
    if abs(fit.mass - expected) <= max(0.1 * rated, 0.2 * expected, 3.0 * fit.std):
        return Finding('load', OK, text)
    if fit.mass < 0.0 == expected:
        # Less than no load is none that somebody forgot to state.
        return Finding('link masses', DOUBT, text, 'no load weighs less than nothing: compare the '
                       'link masses of the URDF and torque constants')
    if expected > 0.3 * rated > abs(fit.mass) and robot.effort.configured_load is None:
        return Finding('load', WRONG, text, 'the driver takes the load off: state '
                       'effort.includes_configured_load, or set the load on the robot to zero')
    return Finding('load', DOUBT, text, 'state the load in load.yaml; compare link masses and '
                   'effort.includes_configured_load')
