"""
Does what was identified make sense, or was a joint of the recordings told wrongly?

A fit finds something for every input. Friction that drives a joint, and links that leave most of
a joint's torque unexplained, are no arm's.
"""

import numpy as np

from ..errors import RecordingError

# Speeds [rad/s] from which on a joint moves, and the share of its motion that is slower than where
# its friction is judged.
MOVES, FAST = 0.05, 0.95
FEWEST = 20
# Every so many rows tell which joints carry weight.
EVERY = 100
# Friction drives by more than so many times the residual; so much of a torque is left [variance]
# where there is something to explain [share of the drive's limit].
DRIVES, LEFT, SOMETHING = 1.0, 0.5, 0.05
CHECK = ('the effort or the angle has the other sign, another unit, or belongs to another joint; '
         'try `hand_load check`')


def nonsense(model, evidence):
    """Return {joint: sentence} where a TorqueModel of Evidence says what cannot be."""
    v = np.concatenate([e.motion.v for e in evidence])
    torque = np.concatenate([e.torque for e in evidence])
    tells = np.concatenate([e.tells for e in evidence]) & (np.abs(v) > MOVES)
    out = {}
    for j, name in enumerate(model.robot.joints):
        if tells[:, j].sum() < FEWEST:
            continue
        own = torque[tells[:, j], j].std()
        speed = np.quantile(np.abs(v[tells[:, j], j]), FAST)
        friction = _friction(model, j, speed)
        if friction < -DRIVES * model.noise[j]:
            out[name] = (f'{name}: what was identified as friction does not brake but drives it '
                         f'({-friction:.2g} Nm at {speed:.2g} rad/s); {CHECK}')
        elif model.noise[j] > np.sqrt(LEFT) * own > np.sqrt(LEFT) * SOMETHING \
                * model.robot.limits.torque[j]:
            out[name] = (f'{name}: the model explains less than half of its torque (varies by '
                         f'{own:.2g} Nm, {model.noise[j]:.2g} Nm are left); {CHECK}, or, where '
                         'the joint has a balancer, declare gravity_spring with --effects')
    return out


def refuse_nonsense(robot, evidence, told):
    """Raise RecordingError where nonsense() told of most of the joints that carry weight."""
    rows = np.concatenate([e.motion.q[::EVERY] for e in evidence])
    loaded = np.any([robot.gravity_loaded(q) for q in rows], axis=0)
    joints = [name for name, carries in zip(robot.joints, loaded) if carries]
    wrong = [name for name in joints if name in told]
    if 2 * len(wrong) > len(joints):
        raise RecordingError(
            f'{", ".join(e.name for e in evidence)}: no model can be made of them, for '
            f'{len(wrong)} of the {len(joints)} joints that carry weight make no sense '
            f'({", ".join(wrong)}); {told[wrong[0]]}')


def _friction(model, j, speed):
    """Return what friction of a joint takes [Nm] at a speed [rad/s] in both directions."""
    n = model.robot.n
    still, v = np.zeros(n), np.where(np.arange(n) == j, speed, 0.0)
    unknown = np.full(n, np.nan)
    return 0.5 * (model.torque(still, v, still, unknown) - model.torque(still, -v, still,
                                                                        unknown))[j]
