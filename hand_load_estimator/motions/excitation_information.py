"""How well the data of a motion will determine the torque of the arm it was run on."""

import numpy as np

# One second of a real arm's coloured torque errors holds about this many independent ones.
INDEPENDENT_RATE = 10.0
# More samples than this change the expected covariance little and cost time.
_MOST_SAMPLES = 600
_TEST_SAMPLES = 300
# [rad/s] over which Coulomb friction changes sign in the design.
SIGN_WIDTH = 0.02
FRICTION = ('coulomb', 'viscous', 'offset', 'rotor')
# Directions of the parameters that move the torque less than this (relative) are not base ones.
_RANK = 1e-7


class Information:
    """
    Expected covariance of link and friction parameters after a motion without load.

    noise (n,) [Nm]: standard deviation of independent torque errors, INDEPENDENT_RATE of them a
    second. Parameters count by the torque they make at test points drawn in the box.
    """

    def __init__(self, robot, box, noise, duration, random):
        self._robot, self.noise = robot, np.asarray(noise, dtype=float)
        self._friction = 1 if robot.effort.kind == 'link_torque' else len(FRICTION)
        self.rate = min(INDEPENDENT_RATE, _MOST_SAMPLES / duration)
        self._test = self._test_points(box, random)
        moments = self._test.reshape(-1, self._test.shape[2])
        values, vectors = np.linalg.eigh(moments.T @ moments / len(moments))
        base = values > _RANK * values[-1]
        # In these coordinates every parameter makes a unit torque at the test points.
        self._base = vectors[:, base] / np.sqrt(values[base])

    @property
    def base_parameters(self):
        """How many combinations of parameters the torque shows at all."""
        return self._base.shape[1]

    def cost(self, q, v, a):
        """Return the mean expected variance of predicted torque over that of the noise."""
        return float(np.trace(self._covariance(q, v, a)) / self._robot.n)

    def torque_std(self, q, v, a):
        """Return expected std [Nm] of predicted torque per joint: of all, of the links, (n,)."""
        full = self._base @ self._covariance(q, v, a) @ self._base.T
        links = 10 * self._robot.n
        whole = np.einsum('tjp,pq,tjq->j', self._test, full, self._test) / len(self._test)
        part = self._test[:, :, :links]
        link = np.einsum('tjp,pq,tjq->j', part, full[:links, :links], part) / len(self._test)
        return self.noise * np.sqrt(whole), self.noise * np.sqrt(link)

    def friction_std(self, q, v, a):
        """Return {name: expected std (n,)} of the friction parameters, empty for link torque."""
        if self._friction == 1:
            return {}
        full = self._base @ self._covariance(q, v, a) @ self._base.T
        std = np.sqrt(np.diag(full)[10 * self._robot.n:]).reshape(self._robot.n, -1)
        return {name: std[:, FRICTION.index(name)] for name in ('coulomb', 'viscous')}

    def _covariance(self, q, v, a):
        rows = self._rows(q, v, a)
        reduced = rows.reshape(-1, rows.shape[2]) @ self._base
        information = reduced.T @ reduced * INDEPENDENT_RATE / self.rate
        return np.linalg.inv(information + 1e-9 * np.trace(information) * np.eye(len(information)))

    def _rows(self, q, v, a):
        """Return the regressor over the noise, (N, n, 10 n + n friction)."""
        n, count = self._robot.n, len(q)
        rows = np.zeros((count, n, 10 * n + n * self._friction))
        for k in range(count):
            rows[k, :, :10 * n] = self._robot.link_regressor(q[k], v[k], a[k])
        terms = [np.ones_like(v)] if self._friction == 1 else [
            np.tanh(v / SIGN_WIDTH), v, np.ones_like(v), a]
        for j in range(n):
            for i, term in enumerate(terms):
                rows[:, j, 10 * n + self._friction * j + i] = term[:, j]
        return rows / self.noise[:, None]

    def _test_points(self, box, random):
        """Return the regressor at points as a working arm meets them."""
        shape = (_TEST_SAMPLES, self._robot.n)
        return self._rows(box.centre + box.reach * random.uniform(-1.0, 1.0, shape),
                          box.velocity * random.uniform(-0.7, 0.7, shape),
                          box.acceleration * random.uniform(-0.5, 0.5, shape))
