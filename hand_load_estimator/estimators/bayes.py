"""Method `bayes`: recursive Bayesian regression with physics for weights (E7.3, eq. 13-14)."""

from .load_prior import load_prior
from .regression import LoadRegression
from .weighting import joined_columns


class Bayes:
    """Estimate the load without any learned part; works for every robot with a torque model."""

    name = 'bayes'

    def __init__(self, model, uncertainties):
        robot = model.robot
        self._regression = LoadRegression(load_prior(robot), robot.n, uncertainties,
                                          robot.effort.torque_constants_std)
        self.mismatch = ""

    @property
    def changes(self):
        """Number of load changes seen."""
        return self._regression.changes

    @property
    def last_change(self):
        """Stamp [s] of the newest load change, or None."""
        return self._regression.last_change

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        self._regression.add(sample, joined_columns(prediction), prediction.difference,
                             sample.dt / prediction.density)
        self._regression.update_posterior()
        return self.belief()

    def belief(self):
        """Return the present Belief."""
        return self._regression.belief()

    def forget(self):
        """Forget the load."""
        self._regression.forget()

    def tare(self):
        """Make what is held now the new zero."""
        self._regression.tare()
