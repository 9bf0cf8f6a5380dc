"""
A histogram filter's lattice of candidates: probabilities, entropy, refining ranges (E2.3, E2.4).

Every parameter's range is split into j points, j^K candidates for K parameters. Axes may lie
askew: after a few samples mass and place are known together far better than each alone, and a
lattice along the parameters would hold no candidate near the ridge.
"""

from functools import lru_cache

import numpy as np

# The lattice reaches so many standard deviations to each side ...
REACH = 3.0
# ... and is laid anew when a standard deviation along some axis leaves these limits, as a
# multiple of the one it was laid for, or when its rim holds more than EDGE of the probability.
NARROW, WIDE, EDGE = 0.7, 1.4, 0.1
# A peak at the rim says little of how far it goes on: widen by at least this.
WIDEN = 2.0


@lru_cache(None)
def _lattice(parameters, points):
    """Return unit coordinates (j^K, K), the step between them, and which are on the rim."""
    axis = np.linspace(-REACH, REACH, points)
    unit = np.stack(np.meshgrid(*[axis] * parameters, indexing='ij'), axis=-1)
    unit = unit.reshape(-1, parameters)
    return unit, axis[1] - axis[0], (np.abs(unit) > 0.999 * REACH).any(axis=1)


class Histogram:
    """
    Existence probabilities over a lattice.

    mean, std (K,): what the first lattice is laid around; points: j. candidates (j^K, K);
    probabilities (j^K,) sum to one.
    """

    def __init__(self, mean, std, points):
        self._unit, self._step, self._rim = _lattice(len(mean), points)
        self._lay(np.asarray(mean, dtype=float), np.diag(std))
        self.probabilities = np.full(len(self._unit), 1.0 / len(self._unit))

    def _lay(self, centre, axes):
        self._centre, self._axes = centre, axes
        self.candidates = centre + self._unit @ axes.T

    def weigh(self, log_density):
        """Set the probabilities from log densities (j^K,) up to a constant."""
        self.probabilities = normalised(log_density)

    def state(self):
        """Return {name: array}: what restore() of a histogram of as many points goes on from."""
        return {'centre': self._centre, 'axes': self._axes, 'probabilities': self.probabilities}

    def restore(self, state):
        """Go on from a state()."""
        self._lay(state['centre'], state['axes'])
        self.probabilities = state['probabilities']

    @property
    def entropy(self):
        """H = -sum p log p (eq. 9)."""
        return entropy_of(self.probabilities)

    @property
    def best(self):
        """The most probable candidate (K,)."""
        return self.candidates[np.argmax(self.probabilities)]

    @property
    def mean(self):
        """Mean (K,)."""
        return self.probabilities @ self.candidates

    def moments(self):
        """Return mean (K,) and covariance (K, K), what a candidate's cell holds included."""
        mean = self.mean
        away = self.candidates - mean
        cell = self._axes @ self._axes.T * (self._step ** 2 / 12.0)
        return mean, (away * self.probabilities[:, None]).T @ away + cell

    def belief(self):
        """
        Return mean (K,) and covariance (K, K): proportions of the moments, size of the entropy.

        A normal density of covariance S has the differential entropy log det(2 pi e S) / 2; the
        histogram's is H plus the logarithm of a cell's volume.
        """
        mean, covariance = self.moments()
        k = len(mean)
        volume = np.linalg.slogdet(self._axes * self._step)[1]
        normal = 0.5 * np.linalg.slogdet(2.0 * np.pi * np.e * covariance)[1]
        return mean, covariance * np.exp(2.0 * (self.entropy + volume - normal) / k)

    def refine(self):
        """Lay the lattice anew where the peak is narrow, wide or at the rim; tell whether."""
        mean, covariance = self.moments()
        inverse = np.linalg.inv(self._axes)
        stds, turn = np.linalg.eigh(inverse @ covariance @ inverse.T)
        stds = np.sqrt(np.maximum(stds, 1e-12))
        at_rim = self.probabilities[self._rim].sum() > EDGE
        if not at_rim and (stds > NARROW).all() and (stds < WIDE).all():
            return False
        if at_rim:
            stds = np.maximum(stds, WIDEN)
        self._lay(mean, self._axes @ turn * stds)
        return True


def normalised(log_density):
    """Return probabilities for log densities up to a constant."""
    weights = np.exp(log_density - log_density.max())
    return weights / weights.sum()


def entropy_of(probabilities):
    """Return H = -sum p log p (eq. 9)."""
    some = probabilities[probabilities > 0.0]
    return float(-(some @ np.log(some)))
