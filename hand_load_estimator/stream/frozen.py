"""Joint states that repeat one another bit for bit: a driver that has lost its robot."""

# Joint states of a robot are not the same to the last bit for so long [s].
FROZEN = 1.0


class Frozen:
    """
    Tell for how long joint states say the same, to the last bit.

    seconds: of the newest ones. Sensors of a robot at rest have noise; only a simulation without
    any may stand like that.
    """

    def __init__(self):
        self.seconds, self._since, self._signal = 0.0, None, None

    def look(self, stamp, signal):
        """Take q, v, effort (3, n) at a stamp [s]."""
        signal = signal.tobytes()
        if signal != self._signal or stamp < self._since:
            self._since, self._signal = stamp, signal
        self.seconds = stamp - self._since


def told_of_frozen(seconds):
    """Return [a sentence on joint states that were the same for so long], or []."""
    return [f'joint states have been the same to the last bit for {seconds:.0f} s: a driver that '
            'has lost its robot, or a simulation without noise'] if seconds > FROZEN else []
