"""A joint trajectory: knots joined by quintic Hermite pieces, as ros2_control joins them."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError

COLUMNS = ('position', 'velocity', 'acceleration')

# Rows: coefficients of s^3, s^4, s^5 for the position gap, h v0, h v1, h^2 a0, h^2 a1.
_QUINTIC = np.array([[10.0, -6.0, -4.0, -1.5, 0.5],
                     [-15.0, 8.0, 7.0, 1.5, -1.0],
                     [6.0, -3.0, -3.0, -0.5, 0.5]])


@dataclass(frozen=True)
class Trajectory:
    """
    Knots of a motion of n joints.

    time (k,) [s], strictly increasing, k >= 2; position (k, n) [rad]; velocity (k, n) [rad/s];
    acceleration (k, n) [rad/s^2]. The arrays are read-only. Between knots the motion is the
    quintic that meets position, velocity and acceleration at both ends; before the first and
    after the last knot the arm holds still. Raises ValueError for arrays that do not fit.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    def __post_init__(self):
        time = np.array(self.time, dtype=float)
        if time.ndim != 1 or len(time) < 2 or not np.all(np.diff(time) > 0.0):
            raise ValueError('time must be at least two strictly increasing numbers')
        object.__setattr__(self, 'time', time)
        for name in COLUMNS:
            array = np.array(getattr(self, name), dtype=float)
            if array.ndim != 2 or array.shape[0] != len(time):
                raise ValueError(f'{name} has shape {array.shape}, expected ({len(time)}, n)')
            object.__setattr__(self, name, array)
        if not self.position.shape == self.velocity.shape == self.acceleration.shape:
            raise ValueError('position, velocity and acceleration differ in shape')
        for array in (self.time, self.position, self.velocity, self.acceleration):
            if not np.all(np.isfinite(array)):
                raise ValueError('a trajectory must be finite')
            array.setflags(write=False)

    @property
    def start(self):
        """Time of the first knot [s]."""
        return float(self.time[0])

    @property
    def end(self):
        """Time of the last knot [s]."""
        return float(self.time[-1])

    @property
    def duration(self):
        """Time from the first to the last knot [s]."""
        return self.end - self.start

    @property
    def n(self):
        """Count of joints."""
        return self.position.shape[1]

    def at_speed(self, share):
        """Return the same path from time 0 on, at a share of its speed (0.5: twice as long)."""
        return Trajectory((self.time - self.start) / share, self.position,
                          self.velocity * share, self.acceleration * share ** 2)

    def sample(self, t):
        """
        Return position, velocity, acceleration at time t [s].

        A scalar t gives (n,) arrays, an array (m,) gives (m, n) arrays.
        """
        t = np.asarray(t, dtype=float)
        times = np.atleast_1d(t)
        i = np.clip(np.searchsorted(self.time, times, side='right') - 1, 0, len(self.time) - 2)
        h = (self.time[i + 1] - self.time[i])[:, None]
        s = np.clip((times - self.time[i])[:, None] / h, 0.0, 1.0)
        out = self._pieces(i, h, s)
        outside = (times < self.time[0]) | (times > self.time[-1])
        for array in out[1:]:
            array[outside] = 0.0
        return tuple(array[0] for array in out) if t.ndim == 0 else out

    def _pieces(self, i, h, s):
        """Return the quintic pieces i, of lengths h, at the fractions s."""
        q0, v0, a0 = self.position[i], self.velocity[i] * h, self.acceleration[i] * h * h
        ends = np.stack([self.position[i + 1] - q0, v0, self.velocity[i + 1] * h,
                         a0, self.acceleration[i + 1] * h * h])
        c3, c4, c5 = np.tensordot(_QUINTIC, ends, axes=1)
        position = q0 + s * (v0 + s * (a0 / 2.0 + s * (c3 + s * (c4 + s * c5))))
        velocity = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        acceleration = a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))
        return position, velocity / h, acceleration / h ** 2

    def shifted(self, offset):
        """Return the same motion `offset` [s] later."""
        return Trajectory(self.time + offset, self.position, self.velocity, self.acceleration)


def hold(position, duration, start=0.0):
    """Return the trajectory that stays at position (n,) for `duration` [s]."""
    q = np.tile(np.asarray(position, dtype=float), (2, 1))
    return Trajectory([start, start + duration], q, np.zeros_like(q), np.zeros_like(q))


def concatenate(parts):
    """
    Return one trajectory of several, each beginning where the one before ends.

    Every part is shifted in time to follow; the knot they share is kept once, the earlier
    part's. Raises ValueError when a part does not begin at the position the one before ends at.
    """
    time, columns = [parts[0].time], [[getattr(parts[0], c)] for c in COLUMNS]
    end = parts[0].end
    for before, part in zip(parts, parts[1:]):
        if not np.allclose(before.position[-1], part.position[0], atol=1e-6):
            raise ValueError(f'a part begins at {part.position[0]} but the one before ends at '
                             f'{before.position[-1]}')
        time.append(part.time[1:] - part.start + end)
        end = time[-1][-1]
        for column, name in zip(columns, COLUMNS):
            column.append(getattr(part, name)[1:])
    return Trajectory(np.concatenate(time), *(np.concatenate(c) for c in columns))


def write_trajectory_csv(path, joints, trajectory):
    """Write the knots: columns t, then <joint>.position, .velocity, .acceleration per joint."""
    header = ['t'] + [f'{joint}.{c}' for joint in joints for c in COLUMNS]
    values = np.stack([getattr(trajectory, c) for c in COLUMNS], axis=2)
    rows = np.column_stack([trajectory.time, values.reshape(len(trajectory.time), -1)])
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([f'{value:.9g}' for value in row] for row in rows)


def read_trajectory_csv(path, joints=None):
    """
    Return (joints, trajectory) of a CSV that write_trajectory_csv wrote.

    joints: the order wanted; None keeps the file's. Raises ConfigurationError.
    """
    path = Path(path)
    try:
        with open(path, newline='', encoding='utf-8') as file:
            header, *rows = [row for row in csv.reader(file) if row] or [[]]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ConfigurationError(path, f'cannot be read ({error})',
                                 todo='give the path of a motion CSV') from None
    header = [name.strip() for name in header]
    found = tuple(dict.fromkeys(name.rsplit('.', 1)[0] for name in header if '.' in name))
    joints = tuple(joints) if joints is not None else found
    wanted = ['t'] + [f'{joint}.{c}' for c in COLUMNS for joint in joints]
    missing = [name for name in wanted if name not in header]
    if missing or not joints:
        raise ConfigurationError(path, 'lacks columns', ', '.join(missing) or 'no joint',
                                 't and <joint>.position, .velocity, .acceleration per joint')
    try:
        table = np.array([[float(row[header.index(name)]) for name in wanted] for row in rows])
        n = len(joints)
        return joints, Trajectory(table[:, 0], *(table[:, 1 + c * n:1 + (c + 1) * n]
                                                 for c in range(3)))
    except (ValueError, IndexError) as error:
        raise ConfigurationError(path, f'is not a motion ({error})', allowed='finite numbers, '
                                 'time strictly increasing, at least two rows') from None
