"""What an identification motion must respect beside its box: torque, floor, the arm's own base."""

import numpy as np
import pinocchio as pin

from ..errors import ConfigurationError

# Places tried for the default centre, and configurations looked at around each.
_CENTRES, _AROUND = 400, 24
# [rad] from a limit to the centre at least; the chosen one is rounded.
_ROOM, _ROUNDING = 0.02, 0.01
_MOST_HELD = 0.9


def torque_use(robot, q, v, a, torque):
    """Return the largest nominal torque without load over the allowed one, (N, n) samples."""
    data = robot.model.createData()
    tau = np.array([pin.rnea(robot.model, data, *sample).copy() for sample in zip(q, v, a)])
    return float(np.max(np.abs(tau) / torque))


class Clearance:
    """
    How far elbow, wrist and load frame stay from the mounting plane and from the base column.

    Joint origins stand for the links: this keeps a motion from hitting the floor, it is no
    collision check.
    """

    def __init__(self, robot):
        self._model, self._data = robot.model, robot.model.createData()
        self._frame = robot.model.getFrameId(robot.load_frame)
        self._n = robot.n
        steps = [np.linalg.norm(self._model.jointPlacements[j].translation)
                 for j in range(2, robot.n + 1)]
        # The wanted distance grows with the arm: 10 cm for one that reaches a metre.
        self.wanted = 0.1 * max(sum(steps), 1e-3)

    def of(self, configurations):
        """Return the smallest distance [m] over configurations (N, n)."""
        return min(self._at(q) for q in configurations)

    def _at(self, q):
        pin.forwardKinematics(self._model, self._data, q)
        pin.updateFramePlacement(self._model, self._data, self._frame)
        joints = np.array([self._data.oMi[j].translation for j in range(1, self._n + 1)])
        tip = self._data.oMf[self._frame].translation
        shoulder = joints[min(1, self._n - 1)]
        moving = np.vstack([joints[2:], tip])
        return min(moving[:, 2].min(), _distance_to_segment(moving[1:], shoulder).min())


def _distance_to_segment(points, end):
    """Return the distances of points to the segment from the origin to `end`."""
    along = np.clip(points @ end / max(end @ end, 1e-12), 0.0, 1.0)
    return np.linalg.norm(points - along[:, None] * end, axis=1)


def choose_centre(robot, reach, random):
    """Return the centre (n,) around which the arm has most clearance, of many drawn."""
    lower, upper = robot.limits.lower, robot.limits.upper
    room = np.minimum(reach, 0.5 * (upper - lower))
    clearance, best = Clearance(robot), None
    around = random.uniform(-1.0, 1.0, (_AROUND, robot.n)) * room
    for _ in range(_CENTRES):
        low, high = np.maximum(lower + room, -np.pi), np.minimum(upper - room, np.pi)
        centre = random.uniform(np.minimum(low, high), np.maximum(low, high))
        found = clearance.of(centre + around)
        if best is None or found > best[0]:
            best = found, centre
    return np.round(best[1], 2)


def check_centre(robot, centre):
    """Raise ConfigurationError for a given centre outside the limits or too heavy to hold."""
    limits, j = robot.limits, _cramped(robot, centre)
    if j is not None:
        raise ConfigurationError('--centre', f'leaves {robot.joints[j]} no room to move',
                                 float(centre[j]), f'between {limits.lower[j]:.3f} and '
                                 f'{limits.upper[j]:.3f} rad')
    use = _holding(robot, centre).max()
    if use > _MOST_HELD:
        raise ConfigurationError('--centre', f'takes {use:.0%} of the allowed torque to hold',
                                 np.asarray(centre).tolist(), f'at most {_MOST_HELD:.0%}',
                                 'choose another centre or compare max_torque')


def check_chosen_centre(robot, centre):
    """Raise ConfigurationError for the joint of the robot file that no centre suits."""
    limits, j = robot.limits, _cramped(robot, centre)
    if j is not None:
        raise ConfigurationError(
            f'{robot.file.where}: joints', f'{robot.joints[j]} has no room to move',
            f'{limits.lower[j]:.3f} to {limits.upper[j]:.3f}',
            f'a range of more than {2.0 * _ROOM + _ROUNDING:g} rad', 'a gripper\'s finger is no '
            'joint of the arm: draft the robot file again with `hand_load new-robot --tip`')
    use = _holding(robot, centre)
    if use.max() > _MOST_HELD:
        joint = robot.joints[int(np.argmax(use))]
        raise ConfigurationError(
            f'{robot.file.where}: max_torque', f'{joint} needs {use.max():.0%} of its allowed '
            'torque to hold the pose with most room', np.asarray(centre).tolist(),
            f'at most {_MOST_HELD:.0%}', 'compare max_torque, or give another pose as --centre')


def _cramped(robot, centre):
    """Return the first joint that has no room around a centre (n,), or None."""
    limits = robot.limits
    cramped = ~((limits.lower + _ROOM < centre) & (centre < limits.upper - _ROOM))
    return int(np.argmax(cramped)) if cramped.any() else None


def _holding(robot, centre):
    """Return the share (n,) of the allowed torque that holds the arm at a centre (n,)."""
    zero, limits = np.zeros(robot.n), robot.limits
    return np.abs(robot.rigid_torque(np.asarray(centre, dtype=float), zero, zero)) / (
        limits.allowed_torque * limits.torque)
