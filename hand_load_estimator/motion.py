"""
Measured joint states -> theta, theta', theta'' and torque, all behind one causal filter.

Differentiating measured signals and leaving the torque alone would compare quantities of
different moments. Here position, velocity and torque pass the same three-stage low-pass
F(s) = (w / (s + w))^3. Velocity and acceleration are F(s) and s F(s) of the velocity, s F(s) and
s^2 F(s) of the position, weighed by their noise (derivatives.py) and read off the filter's own
state: exact derivatives, with nothing differenced. As F commutes with every linear operator,
F[tau] = F[K] m; what K at the filtered motion is short of F[K] is made up for (shown_links.py).
"""

from dataclasses import dataclass, fields
from functools import cached_property
import math

import numpy as np

from .course import MeasuredCourse
from .derivatives import Derivatives

# Bandwidth of each stage [rad/s]: three of them delay by 3 / w = 30 ms and leave a measured
# velocity noise of 2 mrad/s at 500 Hz as about 0.03 rad/s^2 of acceleration.
BANDWIDTH = 100.0
DELAY = 3.0 / BANDWIDTH
# Longest spacing of the outputs [s] while the input is faster than that.
BLOCK = 0.02
# A longer silence restarts the filter: what happened in between is not known.
LONGEST_GAP = 0.25
# Positions further apart [s] are joined by straight lines that show no acceleration in between.
SPARSE = 0.012
# What was fed in so many time constants ago shows by less than 0.3 %.
_FORGOTTEN = 10.0 / BANDWIDTH


def smeared(v, a):
    """
    Tell where the filter's memory holds a reversal, of filtered v [rad/s] and a [rad/s^2].

    What depends on the direction alone is spread over it: it belongs to none of the two.
    """
    return np.abs(v) < DELAY * np.abs(a)


@dataclass(frozen=True)
class MotionSample:
    """
    The filtered state at one moment.

    stamp [s] of the newest message used; dt [s] since the sample before; q, v, a, effort,
    temperature (n,) each; effort in the unit of the message; temperature NaN where unknown.
    fresh: the filter has just (re)started, and a start in motion would still show. messages: how
    many messages came since the sample before. jerk (n,): how fast the acceleration changed since
    the sample before, which tells how much of the motion the filter has smoothed away; course
    (2, STEPS, n): position and velocity as they were measured since the sample before
    (course.py). Both None where no filter has smoothed anything.
    """

    stamp: float
    dt: float
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    effort: np.ndarray
    temperature: np.ndarray
    fresh: bool
    messages: int = 1
    jerk: np.ndarray | None = None
    course: np.ndarray | None = None


def filter_step(dt, w=BANDWIDTH):
    """Return (3, 3) and two (3,): exact step of the filter chain for an input linear over dt."""
    system = np.zeros((5, 5))
    for i in range(3):
        system[i, i] = -w
        system[i, i - 1 if i else 3] = w
    # States 3 and 4 generate the ramp input: u' = slope.
    system[3, 4] = 1.0
    term, total = np.eye(5), np.eye(5)
    squarings = max(0, int(np.ceil(np.log2(max(w * dt, 1e-9)))) + 3)
    step = system * dt / 2.0 ** squarings
    for k in range(1, 12):
        term = term @ step / k
        total = total + term
    for _ in range(squarings):
        total = total @ total
    constant, slope = total[:3, 3], total[:3, 4] / dt
    return total[:3, :3], constant - slope, slope


class MotionFilter:
    """
    Turn accepted joint states into MotionSamples, at most BLOCK apart at fast inputs.

    temperature (n,) [degC]: last known, NaN where unknown; whoever hears the joints writes it.
    """

    def __init__(self, n, temperature=None):
        self._n = n
        self.temperature = np.full(n, np.nan) if temperature is None else temperature
        self._steps = {}
        self._derivatives = Derivatives(n)
        self.gaps = 0
        self.restart()

    def restart(self):
        """Forget the motion (not the temperatures)."""
        self._state, self._acceleration = None, np.zeros(self._n)
        self._period = 0.0

    def update(self, stamp, q, v, effort):
        """
        Return a MotionSample when one is due, else None.

        stamp [s] must increase; q, v, effort (n,); v is NaN altogether where it is not measured.
        """
        signal = np.array((q, v, effort))
        if self._state is not None and stamp - self._stamp > LONGEST_GAP:
            self.gaps += 1
            self._state = None
        if self._state is None or math.isnan(v[0]) != self._without_velocity:
            return self._start(stamp, signal)
        dt = stamp - self._stamp
        if dt > SPARSE:
            self._sparse = stamp
        if self._without_velocity:
            signal[1] = 0.0
        self._advance(dt, signal)
        self._course.hear(stamp, signal[:2])
        self._stamp = stamp
        self._messages += 1
        self._period += 0.1 * (dt - self._period) if self._period else dt
        # Close the block when one more message would overrun it.
        if stamp - self._emitted + self._period <= BLOCK * 1.0001:
            return None
        return self._sample(stamp)

    def _start(self, stamp, signal):
        self._without_velocity = math.isnan(signal[1, 0])
        if self._without_velocity:
            signal[1] = 0.0
        # The filter starts as if the first reading had stood for ever, which is exact at rest;
        # samples are fresh while the start may still show in the acceleration.
        self._state = np.repeat(signal.reshape(1, -1), 5, axis=0)
        self._course = MeasuredCourse(stamp, signal[:2], self._without_velocity)
        self._stamp = self._emitted = stamp
        self._started = self._sparse = stamp
        self._acceleration = np.zeros(self._n)
        self._period, self._messages = 0.0, 0
        return None

    def _advance(self, dt, signal):
        key = max(round(dt, 7), 1e-6)
        if key not in self._steps:
            if len(self._steps) > 4096:
                self._steps.clear()
            self._steps[key] = np.column_stack(filter_step(key))
        # Rows: the three stages, the input before and now, which one product joins.
        state = self._state
        state[3], state[4] = state[4], signal.ravel()
        state[:3] = self._steps[key].dot(state)

    def _sample(self, stamp):
        first, second, third = self._state[:3].reshape(3, 3, self._n)
        w = BANDWIDTH
        motion = np.array((w * (second[0] - third[0]),
                           w * w * (first[0] - 2.0 * second[0] + third[0])))
        if not self._without_velocity:
            motion = self._weighed(motion, np.array((third[1], w * (second[1] - third[1]))))
        dt, self._emitted = stamp - self._emitted, stamp
        messages, self._messages = self._messages, 0
        jerk = (motion[1] - self._acceleration) / dt
        self._acceleration = motion[1]
        return MotionSample(stamp, dt, third[0].copy(), *motion, third[2].copy(),
                            self.temperature.copy(), stamp - self._started < _FORGOTTEN, messages,
                            jerk, self._course.sampled())

    def _weighed(self, of_position, of_velocity):
        """Return velocity and acceleration (2, n), by the velocity alone after a wide step."""
        if self._stamp - self._sparse < _FORGOTTEN:
            self._derivatives.restart()
            return of_velocity
        return self._derivatives.update(of_position, of_velocity)


@dataclass(frozen=True)
class Motion:
    """
    MotionSamples of one recording stacked: stamp, dt, messages (N,); the others (N, n).

    course (N, 2, STEPS, n) and jerk are None where no filter has smoothed the motion. Whoever
    replaces q, v or a replaces them as well.
    """

    stamp: np.ndarray
    dt: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    effort: np.ndarray
    temperature: np.ndarray
    messages: np.ndarray
    jerk: np.ndarray | None = None
    course: np.ndarray | None = None

    @cached_property
    def known(self):
        """What has been computed of it, {Robot: KnownMotion} (torque/motion_inputs.py)."""
        return {}

    @staticmethod
    def of(samples):
        """Stack MotionSamples; those of a starting filter are left out."""
        samples = [s for s in samples if not s.fresh]
        columns = {field.name: [getattr(s, field.name) for s in samples]
                   for field in fields(Motion)}
        return Motion(**{name: None if any(value is None for value in column)
                         else np.array(column) for name, column in columns.items()})

    def part(self, rows):
        """Return the Motion of some rows."""
        values = (getattr(self, field.name) for field in fields(self))
        return Motion(*(None if value is None else value[rows] for value in values))

    def samples(self):
        """Yield the MotionSamples."""
        for k in range(len(self.stamp)):
            row = self.part(k)
            yield MotionSample(row.stamp, row.dt, row.q, row.v, row.a, row.effort,
                               row.temperature, False, row.messages, row.jerk, row.course)
