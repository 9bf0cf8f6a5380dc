"""
Method `lstm`: a trained LSTM corrects and weighs every sample of the regression (E1.3, E6.1).

The network sees motion, torque difference and temperature of each joint (E3.1), the regressor's
domain through the running Bayesian posterior (E4.1), and gives the mean and the variance of the
ten parameters: through its corrections and precisions, and by shift and spread of the outcome.
The forward pass is numpy, because one sample through torch costs more than the arithmetic.
"""

import numpy as np

from ..learning.features import REFRESH, features
from ..learning.network_bounds import CORRECTION, GAIN, SHIFT, SPREAD
from ..load import message_from_shape
from ..torque_model import warmth_of
from .information import message_covariance
from .load_prior import load_prior
from .method import Belief
from .mismatch import MismatchWatch
from .regression import LoadRegression
from .rest_watch import RestWatch
from .weighting import innovation_of, joined_columns


def _sigmoid(x):
    return 1.0 / (1.0 + np.exp(-x))


class LstmCell:
    """One LSTM layer and its linear head, a step at a time; torch's gate order i, f, g, o."""

    def __init__(self, weights):
        self._input = weights['lstm.weight_ih_l0']
        self._hidden = weights['lstm.weight_hh_l0']
        self._bias = weights['lstm.bias_ih_l0'] + weights['lstm.bias_hh_l0']
        self._head, self._head_bias = weights['head.weight'], weights['head.bias']
        self.restart()

    def restart(self):
        """Forget the past."""
        size = self._hidden.shape[1]
        self._h, self._c = np.zeros(size), np.zeros(size)

    def step(self, inputs):
        """Return the head's outputs for inputs (F,)."""
        gates = self._input @ inputs + self._hidden @ self._h + self._bias
        i, f, g, o = np.split(gates, 4)
        self._c = _sigmoid(f) * self._c + _sigmoid(i) * np.tanh(g)
        self._h = _sigmoid(o) * np.tanh(self._c)
        return self._head @ self._h + self._head_bias


def bounded(out, n):
    """Return correction, gain (n,), shift, spread (10,) of the head's outputs."""
    return (CORRECTION * np.tanh(out[:n]), GAIN * np.tanh(out[n:2 * n] / GAIN),
            SHIFT * np.tanh(out[2 * n:2 * n + 10] / SHIFT),
            SPREAD * np.tanh(out[2 * n + 10:] / SPREAD))


class Lstm:
    """Estimate the load with an Artefact; the model may be any of the arm it was trained for."""

    name = 'lstm'

    def __init__(self, model, uncertainties, artefact):
        self._model, self._robot = model, model.robot
        self._prior = load_prior(self._robot)
        doubt = self._robot.effort.torque_constants_std
        self._plain = LoadRegression(self._prior, self._robot.n, uncertainties, doubt,
                                     RestWatch(model.friction_level(), model.noise))
        self._learned = LoadRegression(self._prior, self._robot.n, uncertainties, doubt)
        self._cell = LstmCell(artefact.weights)
        self._calibration = artefact.calibration
        self._level = model.friction_level()
        self._prior_std = np.sqrt(np.diag(self._plain.posterior.covariance))
        self._watch = MismatchWatch(self._robot.joints, model.residuals.rmse)
        self._restart()

    @property
    def changes(self):
        """Number of load changes seen."""
        return self._plain.changes

    @property
    def last_change(self):
        """Stamp [s] of the newest load change, or None."""
        return self._plain.last_change

    @property
    def mismatch(self):
        """Why the model does not explain the residual, or an empty string."""
        return self._watch.reason

    def update(self, sample, prediction):
        """Take one sample; return the Belief after it."""
        columns = joined_columns(prediction)
        innovation, expected = innovation_of(prediction, columns, self._known,
                                             self._plain.posterior)
        self._watch.update(innovation, expected, sample.dt)
        correction, gain, self._shift, self._spread = bounded(
            self._cell.step(self._features(sample, prediction, innovation)), self._robot.n)
        weights = sample.dt / prediction.density
        changes = self._plain.changes
        self._plain.add(sample, columns, prediction.difference, weights)
        self._learned.add(sample, columns, prediction.difference - correction * self._level,
                          weights * np.exp(gain))
        if self._plain.changes > changes:
            self._learned.keep_recent(self._plain.kept)
            self._watch.clear()
        self._count += 1
        if self._count % REFRESH == 0:
            self._renew()
        self._learned.update_posterior()
        return self.belief()

    def belief(self):
        """Return the present Belief."""
        posterior = self._learned.posterior
        std = np.sqrt(np.diag(posterior.shape_covariance))
        shape = posterior.shape + self._shift * std
        wide = np.exp(self._spread)
        covariance = message_covariance(shape, posterior.shape_covariance * np.outer(wide, wide))
        return Belief(message_from_shape(shape),
                      covariance * np.outer(self._calibration, self._calibration))

    def forget(self):
        """Forget the load."""
        self._plain.forget()
        self._learned.forget()
        self._restart()

    def tare(self):
        """Make what is held now the new zero."""
        self._plain.tare()
        self._learned.tare()
        self._restart()

    def _restart(self):
        self._cell.restart()
        self._watch.clear()
        self._count = 0
        self._shift, self._spread = np.zeros(10), np.zeros(10)
        self._renew()

    def _renew(self):
        """Renew the plain posterior behind the innovations."""
        posterior = self._plain.update_posterior()
        self._known = self._plain.known()
        self._relative = np.sqrt(np.diag(posterior.covariance)) / self._prior_std

    def _features(self, sample, prediction, innovation):
        residuals = self._model.residuals
        warmth = np.where(np.isfinite(sample.temperature),
                          warmth_of(self._robot, sample.temperature), np.nan)
        return features(self._robot.limits, residuals.rmse, residuals.intensity,
                        (sample.q, sample.v, sample.a), prediction.difference, innovation,
                        warmth, prediction.z, prediction.doubt, prediction.density,
                        self._relative, np.array(sample.dt))
