"""What every Method says of load changes and tare, from whatever watches for them."""


class Watching:
    """The part of a Method that its `_watcher` answers: a LoadRegression, or another Method."""

    counts_doubts = True

    @property
    def changes(self):
        """Number of load changes seen."""
        return self._watcher.changes

    @property
    def last_change(self):
        """Stamp [s] of the newest load change, or None."""
        return self._watcher.last_change

    @property
    def tared(self):
        """Products (10,) declared zero by tare."""
        return self._watcher.tared

    @property
    def trusted(self):
        """The Trust in the torque model, as what is published counts with it now."""
        return self._watcher.trusted

    def load_as_stated(self):
        """Return products (10,) and covariance (10, 10) as of LoadRegression.load_as_stated."""
        return self._watcher.load_as_stated()

    @property
    def factor(self):
        """How many times as large the variances of torques are as the model states; at least 1."""
        return self._watcher.trust.now.factor

    @property
    def mismatch(self):
        """Why the model does not explain the residual, or an empty string."""
        return self._watcher.mismatch
