"""
The motion as it was measured, before the filter, at even moments between two of its samples.

What the filter gives out is smooth: a reversal within its memory is hardly to be seen in it. What
turns within a reversal, as friction does, has to be evaluated at this motion and then filtered.
"""

import numpy as np

# Moments within a sample: five milliseconds apart at the motion filter's rate.
STEPS = 4
SHARES = np.arange(1, STEPS + 1) / STEPS
# A joint has turned around when it is so far [rad] back. A standing one has to be further: noise
# would rub away what friction it holds. It stands where two samples are within STANDS [rad].
TURNED, STANDS = 3e-5, 2e-4
# Encoders differ: with more noise than 0.03 mrad both are so many of its standard deviations.
DEVIATIONS, SPREAD = 3.0, 8.0
# Noise is told by third differences, over so many samples in which a joint stands: those of one
# in motion tell how its stamps jitter. A sample holds a message for each of its steps: straight
# lines between fewer hide noise. One counts as no more than so many times the mean, once a few
# were seen; two samples are of a standing joint where their means are within so many standard
# deviations.
MEMORY, FEW, LARGEST, STILL = 250, 5, 4.0, 3.0
# Third differences that end within the newer of two samples, (STEPS, 2 STEPS), of white noise with
# its variance.
_THIRD = np.diff(np.eye(2 * STEPS), 3, axis=0)[-STEPS:] / np.sqrt(20.0)


class MeasuredCourse:
    """
    Keep the messages since the last sample: position [rad] and velocity [rad/s], (2, n).

    without_velocity: then it is what the positions tell.
    """

    def __init__(self, stamp, motion, without_velocity):
        self._stamps, self._motions = [stamp], [motion]
        # Between the last message of the sample before and the one before that.
        self._before = (stamp, np.zeros(motion.shape[1])) if without_velocity else None

    def hear(self, stamp, motion):
        """Take the motion (2, n) of a message."""
        self._stamps.append(stamp)
        self._motions.append(motion)

    def sampled(self):
        """Return the course (2, STEPS, n) from the last sample to the newest message."""
        stamps, motions = np.array(self._stamps), np.array(self._motions)
        del self._stamps[:-1], self._motions[:-1]
        at = stamps[0] + (stamps[-1] - stamps[0]) * SHARES
        if self._before is None:
            both = _on_lines(stamps, motions.reshape(len(stamps), -1), at)
            return both.reshape(STEPS, 2, -1).swapaxes(0, 1)
        # A difference of positions is the velocity half way between them.
        q, times = motions[:, 0], np.append(self._before[0], 0.5 * (stamps[1:] + stamps[:-1]))
        v = np.vstack([self._before[1], np.diff(q, axis=0) / np.diff(stamps)[:, None]])
        self._before = times[-1], v[-1]
        return np.stack([_on_lines(stamps, q, at), _on_lines(times, v, at)])


def _on_lines(times, values, at):
    """Return values (N, n) of times (N,) at later times, beyond the last on its line."""
    after = times[1:-1].searchsorted(at) + 1
    before = after - 1
    since, was = times[before], values[before]
    share = (at - since) / (times[after] - since)
    return was + share[:, None] * (values[after] - was)


class Ways:
    """
    The ways of joints from step to step, without what noise turns around.

    q (n,) [rad]: where they begin. Once a joint has turned all of the way back counts.
    """

    def __init__(self, q):
        self._at, self._direction, self._before = q, np.zeros_like(q), q[None]
        self._dt, self._full = 0.0, False
        self._count, self._variance = np.zeros((2, len(q)))

    def along(self, q, dt, messages):
        """
        Return the ways (STEPS, n) [rad] along the positions q (STEPS, n) of a sample.

        dt [s] since the one before, in which so many messages came.
        """
        both = np.concatenate([self._before, q])
        self._learn(both, dt, messages >= STEPS)
        spread, self._before = both.max(axis=0) - both.min(axis=0), q
        noise = np.sqrt(self._variance)
        stands = np.maximum(STANDS, SPREAD * noise)
        moved = q - np.concatenate([self._at[None], q[:-1]])
        if (moved * self._direction > 0.0).all():
            self._at = q[-1]
            return moved
        back = np.where(spread > stands, np.maximum(TURNED, DEVIATIONS * noise), stands)
        return np.array([self._to(now, back) for now in q])

    def _learn(self, both, dt, full):
        """Learn the noise from two samples (2 STEPS, n) that are alike, of messages enough."""
        alike = abs(dt - self._dt) < 0.1 * dt
        told, self._dt, self._full = alike and full and self._full, dt, full
        if not told:
            return
        third = _THIRD.dot(both)
        square = (third * third).sum(axis=0) / STEPS
        moved = both[STEPS:].sum(axis=0) - both[:STEPS].sum(axis=0)
        still = (square > 0.0) & (
            (moved / STEPS) ** 2 < STILL ** 2 * np.maximum(square, self._variance))
        if not still.any():
            return
        square = np.where(self._count < FEW, square, np.minimum(square, LARGEST * self._variance))
        self._count = np.minimum(self._count + still, MEMORY)
        self._variance += still * (square - self._variance) / np.maximum(self._count, 1.0)

    def _to(self, q, back):
        moved = q - self._at
        counts = (moved * self._direction > 0.0) | (np.abs(moved) > back)
        self._at = np.where(counts, q, self._at)
        self._direction = np.where(counts, np.sign(moved), self._direction)
        return np.where(counts, moved, 0.0)
