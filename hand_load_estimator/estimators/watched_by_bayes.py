"""A method that leaves load changes, contacts and mismatch to a `bayes` beside it."""

from .bayes import Bayes
from .watching import Watching


class WatchedByBayes(Watching):
    """
    What such methods have in common: they begin anew after a load change.

    Subclasses: _restart() forgets the load; _belief is the present answer.
    """

    def __init__(self, model, uncertainties):
        self._watcher = self._beside = Bayes(model, uncertainties)

    def settle(self):
        """Look for a load change."""
        self._after(self._beside.settle)

    def belief(self):
        """Return the present Belief."""
        return self._belief

    def forget(self):
        """Forget the load."""
        self._beside.forget()
        self._restart()

    def _counts(self, sample, prediction):
        """Let `bayes` look at a sample; tell whether it is of the load, not of a contact."""
        self._after(self._beside.update, sample, prediction)
        return not self._beside.refused

    def _after(self, look, *at):
        changes = self.changes
        look(*at)
        if self.changes > changes:
            self._restart()
