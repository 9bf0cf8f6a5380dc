"""Follow an arm's positions from message to message: whole turns taken out, jumps told."""

import numpy as np

# A place that is told for so long [s], and none near the old one meanwhile, is where the arm is.
# Anything less is a reading of something else: one wrong message, or another publisher's.
ELSEWHERE = 0.1
# Lets encoders quantise and clocks jitter [rad].
SLACK = 0.02
TURN = 2.0 * np.pi


class Continuity:
    """
    Tell which positions an arm can have gone to.

    speed_limit (n,) [rad/s]: what no joint exceeds; turning (n,) bool: joints whose drivers may
    take out whole turns. restarted: whether what was followed last has no past; turns (n,) [rad]:
    what its positions are ahead of those reported, None where nothing.
    """

    def __init__(self, speed_limit, turning):
        self.speed_limit, self._turning = speed_limit, turning
        self.forget()

    def forget(self):
        """Begin anew, as after the clock was set back."""
        self._last = self._other = self.turns = None
        self.restarted = False

    def follow(self, stamp, q):
        """Tell whether the arm can be at q (n,), as turned on from where it was."""
        raw, last, self.restarted = q, self._last, self._last is None
        if last is not None:
            q = q if self.turns is None else q + self.turns
            if self._apart(last, stamp, q):
                q = self._turned_back(last[1], raw)
                if self._apart(last, stamp, q):
                    return self._elsewhere(stamp, raw)
                self.turns = q - raw
        self._last, self._other = (stamp, q), None
        return True

    def _apart(self, last, stamp, q):
        before, place = last
        reach = self.speed_limit * (stamp - before) + SLACK
        return np.count_nonzero(np.abs(q - place) > reach) > 0

    def _turned_back(self, place, q):
        """Return q (n,) with the whole turns that bring it nearest to a place (n,)."""
        return q + np.where(self._turning, TURN * np.round((place - q) / TURN), 0.0)

    def _elsewhere(self, stamp, q):
        """Note a place the arm cannot have gone to; tell whether it is where the arm is."""
        if self._other is None or self._apart(self._other[1], stamp, q):
            self._other = stamp, (stamp, q)
        since, _ = self._other
        self._other = since, (stamp, q)
        if stamp - since < ELSEWHERE:
            return False
        self._last, self._other, self.turns = (stamp, q), None, None
        self.restarted = True
        return True
