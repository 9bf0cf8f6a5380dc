"""Keep simulated time beside real time, and slow it down when the machine cannot keep up."""


class Pace:
    """
    Tells how far the simulation should have come.

    Where it falls more than `longest_lag` [s, real] behind, the missed time is given up instead
    of being caught up with: the simulated clock runs slower than asked for.
    """

    def __init__(self, real_time_factor, longest_lag=0.1):
        self.factor, self._longest_lag = real_time_factor, longest_lag
        self._real = self._simulated = None
        self._counted = None
        self.achieved = float('nan')

    def set_factor(self, factor, real, simulated):
        """Go on from here at another real-time factor."""
        self.factor, self._real, self._simulated = factor, real, simulated

    def target(self, real, simulated):
        """Return the simulated time to reach now; real, simulated: present times [s]."""
        if self._real is None:
            self._real, self._simulated, self._counted = real, simulated, (real, simulated)
        wanted = self._simulated + (real - self._real) * self.factor
        if wanted - simulated > self._longest_lag * self.factor:
            wanted = simulated + self._longest_lag * self.factor
            self._real, self._simulated = real, wanted
        return wanted

    def count(self, real, simulated):
        """Note the factor achieved since the last call."""
        if self._counted is not None and real > self._counted[0]:
            self.achieved = (simulated - self._counted[1]) / (real - self._counted[0])
        self._counted = (real, simulated)
