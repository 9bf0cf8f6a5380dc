"""
What the drives are told: trajectories taken and interpolated as ros2_control's controller does.

Points with positions only are joined by straight lines, with velocities by cubics, with
accelerations too by quintics. A new trajectory replaces the one under way and starts from the
present set point; after the last point the set point stands still.
"""

import numpy as np

from ..errors import HandLoadError

_STANDSTILL = 1e-4  # [rad/s] the controller accepts at the end of a trajectory
# A braking trajectory begins at a measured position, which at a limit may seem to be beyond it.
_BEYOND = 0.01  # [rad]


class TrajectoryError(HandLoadError, ValueError):
    """A trajectory the drives refuse; the one under way goes on."""


def _table(value, shape, what):
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise TrajectoryError(f'trajectory: {what} are not a table of numbers') from None
    if array.shape != shape:
        raise TrajectoryError(f'trajectory: {what} have shape {array.shape}; allowed: {shape}, '
                              'one row per point and one column per joint')
    if not np.all(np.isfinite(array)):
        raise TrajectoryError(f'trajectory: {what} are not all finite')
    return array


def _checked_times(times):
    times = np.atleast_1d(np.array(times, dtype=float))
    if times.size == 0:
        raise TrajectoryError('trajectory: it is empty; send a braking trajectory to stop')
    if times.ndim != 1 or not np.all(np.isfinite(times)) or times[0] < 0.0 \
            or np.any(np.diff(times) <= 0.0):
        raise TrajectoryError('trajectory: times from start must be finite, not negative and '
                              'strictly increasing')
    return times


def _columns(names, joints):
    """Return where each joint of the arm is in the names of a trajectory."""
    names = list(names)
    unknown = [name for name in names if name not in joints]
    missing = [joint for joint in joints if joint not in names]
    if unknown or missing or len(names) != len(joints):
        raise TrajectoryError(f'trajectory: joints are {", ".join(map(str, names)) or "none"}; '
                              f'allowed: each of {", ".join(joints)} once, in any order')
    return [names.index(joint) for joint in joints]


def _coefficients(h, start, end, order):
    """Return (6, n) polynomial coefficients of a piece of length h; start, end: q, v, a."""
    out = np.zeros((6, len(start[0])))
    gap = end[0] - start[0]
    out[0] = start[0]
    if order == 1:
        out[1] = gap / h
        return out
    v0, v1 = start[1], end[1]
    out[1] = v0
    if order == 3:
        out[2] = (3.0 * gap / h - 2.0 * v0 - v1) / h
        out[3] = (-2.0 * gap / h + v0 + v1) / h ** 2
        return out
    a0, a1 = start[2], end[2]
    out[2] = 0.5 * a0
    out[3] = (20.0 * gap - (8.0 * v1 + 12.0 * v0) * h - (3.0 * a0 - a1) * h ** 2) / (2 * h ** 3)
    out[4] = (-30.0 * gap + (14.0 * v1 + 16.0 * v0) * h
              + (3.0 * a0 - 2.0 * a1) * h ** 2) / (2 * h ** 4)
    out[5] = (12.0 * gap - 6.0 * (v1 + v0) * h - (a0 - a1) * h ** 2) / (2 * h ** 5)
    return out


class Setpoint:
    """
    The set point of n joints: position, velocity, acceleration = state (3, n).

    position (n,): at the start; stops (2, n): least and greatest positions that are obeyed.
    """

    def __init__(self, joints, position, stops):
        self._joints, self._stops = tuple(joints), stops
        self.state = np.zeros((3, len(self._joints)))
        self.state[0] = position
        self._begins, self._ends, self._pieces, self._piece = [], [], [], 0
        self._powers = np.zeros((3, 6))
        self._powers[0, 0] = self._powers[1, 1] = 1.0
        self._powers[2, 2] = 2.0

    def take(self, now, names, times, positions, velocities=None, accelerations=None):
        """Replace the trajectory at time `now` [s]; raises TrajectoryError and changes nothing."""
        times = _checked_times(times)
        order = _columns(names, self._joints)
        shape = (len(times), len(order))
        rows = [_table(positions, shape, 'positions')[:, order]]
        self._refuse_beyond_stops(rows[0])
        for value, what in ((velocities, 'velocities'), (accelerations, 'accelerations')):
            if value is not None:
                rows.append(_table(value, shape, what)[:, order])
        degree = 1
        if velocities is not None:
            degree = 3 if accelerations is None else 5
            fastest = np.max(np.abs(rows[1][-1]))
            if fastest > _STANDSTILL:
                raise TrajectoryError(f'trajectory: the last point moves at {fastest:g} rad/s; '
                                      'allowed: standstill')
        self._replace(now, times, rows, degree)

    def _refuse_beyond_stops(self, positions):
        low, high = self._stops
        beyond = np.maximum(low - positions, positions - high)
        point, joint = np.unravel_index(np.argmax(beyond), beyond.shape)
        if beyond[point, joint] > _BEYOND:
            raise TrajectoryError(
                f'trajectory: {self._joints[joint]} is sent to {positions[point, joint]:g}; '
                f'allowed: {low[joint]:g} to {high[joint]:g}, the limits of the URDF')

    def _replace(self, now, times, rows, degree):
        knots = [tuple(row[k] for row in rows) for k in range(len(times))]
        if times[0] > 0.0:
            knots.insert(0, tuple(self.state.copy()))
            times = np.concatenate([[0.0], times])
        elif len(times) == 1:
            # `Be there now`: the drives get there within one of their own cycles.
            knots, times = [knots[0]] * 2, np.array([0.0, 1e-3])
        self._pieces = [_coefficients(h, knots[k], knots[k + 1], degree)
                        for k, h in enumerate(np.diff(times))]
        self._begins = (now + times[:-1]).tolist()
        self._ends = (now + times[1:]).tolist()
        self._piece = 0
        self._last = knots[-1][0]

    @property
    def moving(self):
        """Tell whether a trajectory is under way."""
        return bool(self._pieces)

    def advance(self, now):
        """Return the state (3, n) at time `now` [s]; times only grow."""
        if not self._pieces:
            return self.state
        while now > self._ends[self._piece] - 1e-9:
            self._piece += 1
            if self._piece == len(self._pieces):
                self._pieces = []
                self.state[0] = self._last
                self.state[1:] = 0.0
                return self.state
        s = now - self._begins[self._piece]
        s2 = s * s
        s3, powers = s2 * s, self._powers
        powers[0, 1:] = s, s2, s3, s3 * s, s3 * s2
        powers[1, 2:] = 2.0 * s, 3.0 * s2, 4.0 * s3, 5.0 * s3 * s
        powers[2, 3:] = 6.0 * s, 12.0 * s2, 20.0 * s3
        np.dot(powers, self._pieces[self._piece], out=self.state)
        return self.state
