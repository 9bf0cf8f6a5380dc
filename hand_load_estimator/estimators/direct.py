"""
Methods that go from motion and torque difference to the load by a network alone.

`lstm_direct`, `gru`, `elman`, `jordan` (E1.3), `feedforward` (E1.4), `two_network` (E1.6),
`dropout` (E6.2); the artefact says which, and which joints and parameters (E1.5). A method
`bayes` runs beside it for what a network cannot tell: load changes, which restart the network,
contacts, whose samples it does not see, mismatch and tare.
"""

import numpy as np
import torch

from ..learning.direct_network import Judge, inputs_of
from ..learning.network_memory import NetworkMemory
from ..learning.stated_factors import calibrated
from ..load import message_from_shape, products_jacobian_of_message
from ..torque.columns import warmth_of
from .information import message_covariance
from .load_prior import load_prior
from .method import Belief, check_origin, fitting, joined_state, LIGHT, part_of
from .watched_by_bayes import WatchedByBayes


class Direct(WatchedByBayes):
    """Estimate the load with a DirectArtefact; the model may be any of the arm it is for."""

    counts_doubts = False

    def __init__(self, model, uncertainties, artefact):
        super().__init__(model, uncertainties)
        design = artefact.network.design
        self.name = design.network
        self._robot = model.robot
        self._joints = [model.robot.joints.index(name) for name in design.joints]
        self._picked, self._artefact = design.picked, artefact
        self._fingerprint = artefact.fingerprint
        self._judge = Judge(model.robot, artefact.network)
        self._memory = NetworkMemory(self._judge, 5 * len(self._joints) + 1)
        prior = load_prior(self._robot)
        self._prior = Belief(message_from_shape(prior.mean),
                             message_covariance(prior.mean, np.diag(prior.std ** 2)))
        self._zero_doubt = np.zeros((10, 10))
        self._restart()

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        if not self._counts(sample, prediction):
            return self._belief
        difference = prediction.difference - prediction.load_columns @ self.tared
        warmth = np.where(np.isfinite(sample.temperature),
                          warmth_of(self._robot, sample.temperature), np.nan)
        q, v, a, difference, warmth = torch.tensor(
            np.stack([sample.q, sample.v, sample.a, difference, warmth]), dtype=torch.float32)
        x = inputs_of(self._robot, self._joints, (q, v, a), difference, warmth)
        mean, std, self._state = self._judge(x[None, None], self._state)
        self._belief = self._published(mean[0, 0].double().numpy(), std[0, 0].double().numpy())
        return self._belief

    def tare(self):
        """Make what is held now the new zero, as `bayes` beside sees it, and keep its doubt."""
        held = self._beside.belief()
        jacobian = products_jacobian_of_message(held.mean)
        self._zero_doubt = jacobian @ held.covariance @ jacobian.T
        self._beside.tare()
        self._restart()

    def state(self):
        """Return the states of `bayes` beside and of the network, and its last answer."""
        return {**joined_state(beside=self._beside.state(),
                               memory=self._memory.arrays_of(self._state)),
                'mean': self._belief.mean, 'covariance': self._belief.covariance,
                'zero_doubt': self._zero_doubt, 'weights': self._fingerprint}

    def restore(self, state):
        """Go on from a state() of the same artefact."""
        check_origin(state, 'weights', self._fingerprint, 'learned artefact')
        own = fitting(state, self.state())
        self._beside.restore(part_of(own, 'beside'))
        self._state = self._memory.state_of(part_of(own, 'memory'))
        self._belief = Belief(own['mean'], own['covariance'])
        self._zero_doubt = own['zero_doubt']

    def _restart(self):
        self._state, self._belief = None, self._prior

    def _published(self, mean, std):
        """Return the Belief of a network's answer (10,), the prior's where it has none."""
        picked = self._picked
        out, covariance = self._prior.mean.copy(), self._prior.covariance.copy()
        out[picked] = mean[picked]
        variance = calibrated(std, picked, self._artefact.knots, self._artefact.factors) ** 2
        # The network tells no correlations.
        covariance[picked], covariance[:, picked] = 0.0, 0.0
        covariance[picked, picked] = variance[picked]
        return Belief(out, covariance + self._doubt_of_zero(out))

    def _doubt_of_zero(self, mean):
        """Return what the doubt (10, 10) about tared products does to a load in message order."""
        if not self._zero_doubt.any():
            return self._zero_doubt
        heavy = mean.copy()
        heavy[0] = max(heavy[0], LIGHT * self._robot.rated_load.mass)
        inverse = np.linalg.inv(products_jacobian_of_message(heavy))
        return inverse @ self._zero_doubt @ inverse.T
