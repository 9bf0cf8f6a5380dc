"""
The motion as it was measured, before the filter, at even moments between two of its samples.

What the filter gives out is smooth: a reversal within its memory is hardly to be seen in it. What
turns within a reversal, as friction does, has to be evaluated at this motion and then filtered.
"""

import numpy as np

# Moments within a sample: five milliseconds apart at the motion filter's rate.
STEPS = 4
SHARES = np.arange(1, STEPS + 1) / STEPS
# A joint has turned around when it is so far [rad] back. Encoders of arms have a noise of up to
# 3e-5 rad, which would rub away what friction a standing joint holds: where two samples are within
# NOISE [rad], it has to be that far.
TURNED, NOISE = 3e-5, 2e-4


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

    def along(self, q):
        """Return the ways (STEPS, n) [rad] along the positions q (STEPS, n) of a sample."""
        spread, self._before = np.ptp(np.concatenate([self._before, q]), axis=0), q
        back = np.where(spread > NOISE, TURNED, NOISE)
        return np.array([self._to(now, back) for now in q])

    def _to(self, q, back):
        moved = q - self._at
        counts = (moved * self._direction > 0.0) | (np.abs(moved) > back)
        self._at = np.where(counts, q, self._at)
        self._direction = np.where(counts, np.sign(moved), self._direction)
        return np.where(counts, moved, 0.0)
