"""What recordings cannot tell, said before anything is concluded from them."""

from dataclasses import replace

import numpy as np

from ...effects import NEEDS_TEMPERATURE
from ...errors import RecordingError
from ...motion import SPARSE
from ..measured.find import find_residual
from ..outside.standing import POSE
from .another_robot import refuse_another_robot
from .time_left import names, refuse_too_short

STILL = 0.02           # [rad/s] a joint that never exceeds it has not moved
LEAST_WARMING = 3.0    # [K] between coldest and warmest
# Between joint states that come less often [Hz] positions are guessed at, and when a torque came.
SLOWEST_RATE = 30.0
# Of those that come less often than this accelerations are the velocities' alone, whose noise
# looks like a delay of a third of the time between them.
FALSE_DELAYS = 1.0 / SPARSE
NEARLY = 0.5           # of the gain needed: what gains less is not worth a sentence


def refuse_the_useless(model, evidence):
    """Raise RecordingError where nothing at all can be told."""
    for e in evidence:
        if e.torque.shape[1] != model.robot.n:
            raise RecordingError(f'{e.name}: has {e.torque.shape[1]} joints, the model '
                                 f'{model.robot.n}')
    refuse_too_short(evidence, evidence)
    if max(np.abs(e.motion.v).max() for e in evidence) < STILL:
        raise RecordingError(f'{names(evidence)}: no joint moves, and at rest friction hides '
                             'everything; record a motion of `hand_load excite`')
    refuse_another_robot(model, evidence)


def warmed_joints(model, evidence):
    """Return indices of joints whose temperature changes enough, sentences on the others."""
    columns = np.concatenate([e.motion.temperature for e in evidence]).T
    known = [column[np.isfinite(column)] for column in columns]
    if not any(len(column) for column in known):
        modelled = any(use.name in NEEDS_TEMPERATURE for use in model.uses)
        return (), [f'cannot tell effects of temperature because {_none(evidence)}'
                    + '; friction as of another temperature counts as expected' * modelled]
    spans = [float(np.ptp(column)) if len(column) else 0.0 for column in known]
    warmed = tuple(j for j, span in enumerate(spans) if span >= LEAST_WARMING)
    if not warmed:
        return (), [f'cannot tell effects of temperature because the joints differ by only '
                    f'{max(spans):.1f} K over all recordings; {LEAST_WARMING:g} K are needed']
    why = [f'it differs by only {span:.1f} K; {LEAST_WARMING:g} K are needed' if len(column)
           else 'none was recorded' + ', or none that was usable' * bool(_refused(evidence))
           for span, column in zip(spans, known)]
    return warmed, [*_without_temperature(evidence), *(
        f'cannot tell effects of temperature of {model.robot.joints[j]} because {why[j]}'
        for j in range(model.robot.n) if j not in warmed)]


def _refused(evidence):
    """Return how many readings of recordings were no temperature of a joint."""
    counts = {e.mark: sum(e.rejected.get(reason, 0) for reason in (
        'implausible_temperature', 'zero_temperature')) for e in evidence}
    return sum(counts.values())


def _none(evidence):
    """Return in words why a temperature is not known."""
    count = _refused(evidence)
    return (f'{count} readings are no temperature of a joint in degC (kelvin, or zero '
            'for none? try `hand_load check`)') if count else 'none was recorded'


def _without_temperature(evidence):
    """Return the sentence on recordings of which no joint's temperature is known at all."""
    without = [e for e in evidence if not np.isfinite(e.motion.temperature).any()]
    return [f'cannot tell what of {names(without)} is of temperature because {_none(without)} '
            'there; the other recordings say what depends on it'] if without else []


def slow_joint_states(evidence):
    """Return the sentence on recordings whose joint states come too rarely for delays."""
    rates = {e.name: 1.0 / np.median(e.motion.dt / e.motion.messages) for e in evidence}
    slow = {name: rate for name, rate in rates.items() if rate < FALSE_DELAYS}
    if not slow:
        return []
    rate, names_of = min(slow.values()), ', '.join(slow)
    return [f'cannot tell delays, and little of quick motion, because {names_of} has joint states '
            f'at {rate:.0f} Hz only; {SLOWEST_RATE:g} Hz are needed'
            if rate < SLOWEST_RATE else
            f'cannot tell delays below {500.0 / rate:.0f} ms because {names_of} has joint states '
            f'at {rate:.0f} Hz only; {np.ceil(FALSE_DELAYS):.0f} Hz are needed']


def true_delay(residual, seconds):
    """Tell whether a delay [s] is more than what slow joint states of a Residual look like."""
    longest = residual.longest_interval
    return longest * FALSE_DELAYS <= 1.0 or abs(seconds) > 0.5 * longest


def noisier_recordings(residual, evidence):
    """Return the sentences on Evidence of a Residual that is noisier than the model states."""
    if residual.noisier is None:
        return []
    times = {}
    for own, most in zip(evidence, residual.noisier.max(axis=1)):
        times[own.name] = max(times.get(own.name, 1.0), most)
    return [f'cannot tell weak effects from {name}, whose torques are {np.sqrt(most):.1f} '
            'times as noisy as the model states: joint states come less often than in its own '
            'recordings, or sensors are noisier'
            for name, most in times.items() if most > 1.0]


def still_joints(model, evidence):
    """
    Return {joint index: sentence} for joints that never move.

    A joint that is pushed while it is held is fast for a moment, and stays where it is.
    """
    moves = np.any([(np.abs(e.motion.v).max(axis=0) >= STILL)
                    & (np.ptp(e.motion.q, axis=0) >= POSE) for e in evidence], axis=0)
    return {int(j): f'cannot tell friction, ripple or cables of {model.robot.joints[j]} because '
            'it never moves in what is diagnosed' for j in np.flatnonzero(~moves)}


def usable_residual(model, evidence):
    """Return (Residual without joints that never move, still_joints)."""
    still = still_joints(model, evidence)
    residual = find_residual(model, evidence)
    weights = residual.weights.copy()
    weights[:, list(still)] = 0.0
    return replace(residual, weights=weights), still


def too_little_gained(robot, candidates, needed, joints):
    """
    Return a sentence for each of `joints` (indices) that an effect nearly explains.

    candidates: effects in the order of their gains, each less than `needed` [nats].
    """
    best = {j: next((c for c in candidates if j in c.joints and c.gain >= NEARLY * needed), None)
            for j in joints}
    return [f'cannot tell whether {robot.joints[j]} has {c.name} because its gain of {c.gain:.0f} '
            f'nats is less than the {needed:.0f} needed; record more motion'
            for j, c in best.items() if c is not None]
