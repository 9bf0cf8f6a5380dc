"""
Contacts while the arm is held in a pose: torques beyond what friction can hold.

Friction at rest may be anything up to its level, and stays where it was left: no density of noise
describes that. But it cannot be more. What differs from the model by more than twice that acts
from outside.
"""

from dataclasses import replace

import numpy as np

from ...errors import RecordingError
from .contact import contact, ELSEWHERE, SHORTEST
from .disturbance import Cause, Disturbance, LEFT_OUT
from .interval import Kind

POSE = 0.01            # [rad] within which all joints of an arm that is held stay
# In units of what friction can hold: cold friction is half as much again, and a joint breaks away
# later than it slides. A contact begins beyond the first and lasts to the second.
BREAKS, LASTS = 2.0, 1.0
# A model that saw a joint stand all the time knows no friction of it: it is this share of the
# largest torque at least.
LEAST_FRICTION = 0.03
# A push of the hand explains this share of the torques, or it is another link that is pushed.
EXPLAINED = 0.9
# Friction leaves little to tell a force by: what it may be is as wide as for people that lean.
WIDER = 3.0


def is_held(evidence):
    """Tell whether an arm stays in one pose throughout an Evidence."""
    return bool((np.ptp(evidence.motion.q, axis=0) < POSE).all())


class Standing:
    """
    Contacts in the recordings, Evidence each, in which an arm is held; residual: of them all.

    found: tuple of Disturbance in the order of time; torque (N, n) [Nm]: measured less modelled at
    rest, zero in other recordings. Raises RecordingError where one differs from the model by more
    than friction all the time.
    """

    def __init__(self, model, evidence, residual):
        self._model, self._residual = model, residual
        self._hold = np.maximum(model.friction_level() + model.noise,
                                LEAST_FRICTION * model.robot.limits.torque)
        self.torque = np.zeros_like(residual.residual)
        self.found = ()
        for k, e in enumerate(evidence):
            if is_held(e):
                self._look_at(k, e, np.flatnonzero(residual.owner == k))

    def _look_at(self, k, evidence, rows):
        self.torque[rows] = evidence.torque - _at_rest(self._model, evidence.motion)
        usual = np.median(self.torque[rows], axis=0)
        worst = int(np.argmax(np.abs(usual) / self._hold))
        if abs(usual[worst]) > BREAKS * self._hold[worst]:
            raise RecordingError(
                f'{evidence.name}: the arm stands, and the torque of '
                f'{self._model.robot.joints[worst]} is {usual[worst]:.3g} Nm off the model\'s, of '
                f'which friction can hold {self._hold[worst]:.2g}; another load than declared, '
                'another robot, or something that it leans on; try `hand_load check`')
        self.found += tuple(self._contact(k, rows[0] + first, rows[0] + stop)
                            for first, stop in self._spans(rows))

    def _spans(self, rows):
        """Return (first, stop) within a recording of times beyond what friction can hold."""
        times = np.abs(self.torque[rows] / self._hold).max(axis=1)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], times > LASTS, [0]])))
        return [(a, b) for a, b in zip(edges[::2], edges[1::2]) if times[a:b].max() > BREAKS
                and self._residual.dt[rows[a:b]].sum() > SHORTEST]

    def _contact(self, k, first, stop):
        """Return the Disturbance of rows first..stop: a force on the hand, or some torques."""
        push, torques = self._causes()
        mean = self.torque[first:stop].mean(axis=0)
        theta, covariance, left = self._fit(push.kind, mean, first, stop)
        weights = 1.0 / self._hold ** 2
        cause = push
        if weights @ left ** 2 > (1.0 - EXPLAINED) * (weights @ mean ** 2):
            cause = torques
            theta, covariance, left = self._fit(torques.kind, mean, first, stop)
        # What friction may hold needs no explanation.
        explained = np.where(np.abs(mean) > self._hold,
                             np.clip(1.0 - (left / mean) ** 2, 0.0, 1.0), 0.0)
        unknown = np.nan
        return Disturbance(cause, k, first, stop, theta, covariance, self._time(k, first),
                           self._time(k, stop), unknown, unknown, 1, None, None, explained)

    def _causes(self):
        """Return the Causes: a push of the hand, and one of any link."""
        push = contact(self._model.robot, self._residual)
        kind = replace(push.kind, columns=WIDER * push.kind.columns,
                       scale=WIDER * push.kind.scale)
        count, n = self.torque.shape
        limits = self._model.robot.limits.torque
        every = Kind(ELSEWHERE, np.broadcast_to(np.diag(limits), (count, n, n)), limits, kind.cell,
                     kind.shortest, kind.longest, False)
        return replace(push, kind=kind), Cause(every, push.possible)

    def _fit(self, kind, mean, first, stop):
        """Return theta, covariance in physical units and what is left (n,) of mean torques."""
        columns = kind.columns[first:stop].mean(axis=0)
        # Friction is anywhere between its two levels.
        weighted = columns.T * (3.0 / self._hold ** 2)
        covariance = np.linalg.inv(weighted @ columns + np.eye(columns.shape[1]))
        theta = covariance @ (weighted @ mean)
        return (theta * kind.scale, covariance * np.outer(kind.scale, kind.scale),
                mean - columns @ theta)

    def _time(self, k, row):
        """Return (time, std) [s] of an edge, None at an end of the recording."""
        own = np.flatnonzero(self._residual.owner == k)
        if row <= own[0] or row > own[-1]:
            return None
        return float(self._residual.time[row] - self._residual.time[own[0]]), LEFT_OUT


def _at_rest(model, motion):
    """Return the torque (N, n) [Nm] of a model that stands, without friction."""
    still = np.zeros(motion.q.shape)
    return model.torques(motion.q, still, still, motion.temperature)
