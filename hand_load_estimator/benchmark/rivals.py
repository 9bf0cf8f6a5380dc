"""
The baselines every table shows beside us, as a careful user would write them.

Both regress the torque difference on the ten products with the same weak prior, weighing joints
by their noise: one on the robot file's nominal model, recursively, sample by sample; the other on
a model identified from the same recordings with Coulomb and viscous friction, once with every
sample and once leaving out joints that stand still. The latter looks through our torque model
too: beside it stands what our method adds to the model.
"""

import numpy as np

from ..estimators.load_prior import load_prior
from ..estimators.method import Belief
from ..identification.identify import identify
from ..load import message_from_products

STANDING = 0.02   # [rad/s]
COULOMB_VISCOUS = ('link_inertia', 'rotor_inertia', 'coulomb_friction', 'viscous_friction',
                   'torque_offset')


def textbook_model(robot, evidence):
    """Return the TorqueModel of COULOMB_VISCOUS by plain least squares over all Evidence."""
    return identify(robot, evidence, COULOMB_VISCOUS, drifting=False)


class LeastSquares:
    """Recursive least squares of the products with a Gaussian prior."""

    def __init__(self, model, skip_standing):
        self._skip = skip_standing
        self._mean, self._covariance = load_prior(model.robot).products
        self._variance = model.residuals.rmse ** 2

    def update(self, sample, prediction):
        """Take one sample, joint by joint; return the Belief."""
        for j, row in enumerate(prediction.load_columns):
            if self._skip and abs(sample.v[j]) < STANDING:
                continue
            gain = self._covariance @ row
            scale = self._variance[j] + row @ gain
            self._mean = self._mean + gain * ((prediction.difference[j] - row @ self._mean)
                                              / scale)
            self._covariance = self._covariance - np.outer(gain, gain) / scale
        return self.belief()

    def belief(self):
        """Return the Belief, its covariance by linearisation."""
        mean, step = message_from_products(self._mean), 1e-6
        jacobian = np.array([
            (message_from_products(self._mean + step * e) - mean) / step for e in np.eye(10)]).T
        return Belief(mean, jacobian @ self._covariance @ jacobian.T)


class FixedLoad:
    """What a controller assumes that estimates nothing: the rated load, for ever."""

    def __init__(self, robot):
        self._belief = Belief(robot.rated_load.to_message(), np.zeros((10, 10)))

    def update(self, sample, prediction):
        """Return the rated load."""
        return self._belief
