"""Is the time between two ticks the controller's own, a stall, or a clock that was set."""

LATE = 0.5  # [s] since the last tick: joint states may still wait to be heard


class TickClock:
    """
    now [s] of the last tick, None before any; late: whether that one was.

    A late tick leaves it open whether the controller or the clock was at fault; the next joint
    state tells, as it says where the arm is.
    """

    def __init__(self):
        self.now, self.late = None, False
        self._ahead, self._late_at, self._heard = 0.0, 0.0, 0

    def tick(self, now, heard):
        """Take a tick at `now` [s] after so many joint states; return the step [s] to it."""
        step = 0.0 if self.now is None else now - self.now
        self.late, self.now = step >= LATE, now
        if step < 0.0:
            # What the clock did before is still to be told.
            self._late_at += step
        if self.late:
            # Twice in a row is a machine with too much work, not a clock.
            self._ahead = 0.0 if self._ahead else step
            self._late_at, self._heard = now, heard
        return step

    def open(self, patience):
        """Tell whether a step is still to be told, at most `patience` [s] after it."""
        return self._ahead > 0.0 and self.now - self._late_at < patience

    def told(self, heard):
        """Return the step [s] that joint states heard by now can tell, once; else 0."""
        if not self._ahead or heard <= self._heard:
            return 0.0
        step, self._ahead = self._ahead, 0.0
        return step
