"""What recordings cannot tell, said before anything is concluded from them."""

import numpy as np

from ..errors import RecordingError

STILL = 0.02           # [rad/s] a joint that never exceeds it has not moved
LEAST_WARMING = 3.0    # [K] between coldest and warmest
SATURATED, HELD = 0.02, 0.9   # shares of the time at the largest effort
STRANGE = 0.5          # share of a torque's variance that a model of this arm leaves at most
PUSHED = 0.1           # share of the time in which something may act on the arm from outside
LEAST_SECONDS = 4.8    # twelve blocks of 0.4 s
NEARLY = 0.5           # of the gain needed: what gains less is not worth a sentence


def refuse_the_useless(model, evidence):
    """Raise RecordingError where nothing at all can be told."""
    for e in evidence:
        if e.torque.shape[1] != model.robot.n:
            raise RecordingError(f'{e.name}: has {e.torque.shape[1]} joints, the model '
                                 f'{model.robot.n}')
    seconds = sum(float(e.motion.dt.sum()) for e in evidence)
    if seconds < LEAST_SECONDS:
        raise RecordingError(f'{_names(evidence)}: hold {seconds:.1f} s; a diagnosis needs '
                             f'{LEAST_SECONDS:g} s of motion at least; record a motion of '
                             '`hand_load excite`')
    if max(np.abs(e.motion.v).max() for e in evidence) < STILL:
        raise RecordingError(f'{_names(evidence)}: no joint moves, and at rest friction hides '
                             'everything; record a motion of `hand_load excite`')
    refuse_another_robot(model, evidence)


def refuse_another_robot(model, evidence):
    """Raise RecordingError where a model does not belong to the arm, unit or mounting at all."""
    for mark in dict.fromkeys(e.mark for e in evidence):
        # The parts of a recording together: in a short one alone hardly a joint may have moved,
        # and at rest friction hides what the model explains.
        parts = [_explained(model, e) for e in evidence if e.mark == mark]
        measured, modelled = (np.concatenate(rows) for rows in zip(*parts))
        loaded = modelled.std(axis=0) > 5.0 * model.noise
        if loaded.any() and np.median(_left(measured, modelled)[loaded]) > STRANGE:
            raise RecordingError(
                f'{mark.name}: the model explains less than half of the torque of half the joints '
                'that carry load; it belongs to another robot, unit, sign or mounting; try '
                '`hand_load check`')


def _explained(model, evidence):
    """Return measured and modelled torque (M, n) [Nm] of every tenth row of an Evidence."""
    motion = evidence.motion
    rows = zip(*(values[::10] for values in (motion.q, motion.v, motion.a, motion.temperature)))
    return evidence.torque[::10], np.array([model.torque(*row) for row in rows])


def _left(measured, modelled):
    """
    Return the share (n,) of measured torques' variance (M, n) that a model of them leaves.

    Without each joint's worst rows: a hard push has more squares than minutes of the arm's own
    torque, while another robot's model is wrong all the time.
    """
    error = measured - modelled
    usual = np.abs(error) <= np.quantile(np.abs(error), 1.0 - PUSHED, axis=0)
    count = usual.sum(axis=0)
    off = measured - (usual * measured).sum(axis=0) / count
    return (usual * error ** 2).sum(axis=0) / np.maximum((usual * off ** 2).sum(axis=0), 1e-12)


def _names(evidence):
    return ', '.join(e.name for e in evidence)


def warmed_joints(model, evidence):
    """Return indices of joints whose temperature changes enough, sentences on the others."""
    columns = np.concatenate([e.motion.temperature for e in evidence]).T
    known = [column[np.isfinite(column)] for column in columns]
    if not any(len(column) for column in known):
        return (), ['cannot tell effects of temperature because none was recorded']
    spans = [float(np.ptp(column)) if len(column) else 0.0 for column in known]
    warmed = tuple(j for j, span in enumerate(spans) if span >= LEAST_WARMING)
    if not warmed:
        return (), [f'cannot tell effects of temperature because the joints differ by only '
                    f'{max(spans):.1f} K over all recordings; {LEAST_WARMING:g} K are needed']
    return warmed, [f'cannot tell effects of temperature of {model.robot.joints[j]} because it '
                    f'differs by only {span:.1f} K; {LEAST_WARMING:g} K are needed'
                    for j, span in enumerate(spans) if j not in warmed]


def still_joints(model, evidence):
    """Return {joint index: sentence} for joints that never move."""
    fastest = np.max([np.abs(e.motion.v).max(axis=0) for e in evidence], axis=0)
    return {j: f'cannot tell friction, ripple or cables of {model.robot.joints[j]} because it '
            'never moves' for j in np.flatnonzero(fastest < STILL)}


def saturated_rows(model, evidence):
    """Return (rows (N, n) bool at the drive's limit, sentences)."""
    rows, sentences = [], []
    for e in evidence:
        effort = np.abs(e.motion.effort)
        top = effort.max(axis=0)
        at = (effort > 0.998 * top) & (top > 0.0)
        share = at.mean(axis=0)
        # An effort that never changes belongs to a joint that is held.
        bad = (share > SATURATED) & (share < HELD)
        sentences += [f'{e.name}: the effort of {model.robot.joints[j]} stands at its largest '
                      f'value for {100 * share[j]:.0f} % of the time; those samples are left out'
                      for j in np.flatnonzero(bad)]
        rows.append(at & bad)
    return np.concatenate(rows), sentences


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
