"""
The motion as it was measured, before the filter, at even moments between two of its samples.

What the filter gives out is smooth: a reversal within its memory is hardly to be seen in it. What
turns within a reversal, as friction does, has to be evaluated at this motion and then filtered.
"""

import numpy as np

# Moments within a sample: five milliseconds apart at the motion filter's rate.
STEPS = 4
SHARES = np.arange(1, STEPS + 1) / STEPS


class MeasuredCourse:
    """Keep the messages since the last sample: position [rad] and velocity [rad/s], (2, n)."""

    def __init__(self, stamp, motion):
        self._stamps, self._motions = [stamp], [motion]

    def hear(self, stamp, motion):
        """Take the motion (2, n) of a message."""
        self._stamps.append(stamp)
        self._motions.append(motion)

    def sampled(self, without_velocity):
        """
        Return the course (2, STEPS, n) from the last sample to the newest message.

        Without a measured velocity it is that of the positions from step to step.
        """
        stamps, motions = np.array(self._stamps), np.array(self._motions)
        self._stamps, self._motions = self._stamps[-1:], self._motions[-1:]
        step = (stamps[-1] - stamps[0]) / STEPS
        at = stamps[0] + (stamps[-1] - stamps[0]) * SHARES
        after = np.clip(np.searchsorted(stamps, at), 1, len(stamps) - 1)
        share = (at - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
        course = motions[after - 1] + share[:, None, None] * (motions[after] - motions[after - 1])
        course = course.swapaxes(0, 1)
        if without_velocity:
            course[1] = np.diff(course[0], axis=0, prepend=motions[:1, 0]) / step
        return course
