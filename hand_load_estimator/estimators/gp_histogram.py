"""
Method `gp_histogram`: learned no-load difference and a histogram filter (E2.1-E2.4, E6.3, E6.4).

Mass and centre of mass share one lattice of four parameters; the inertia follows by conditional
steps, three moments and then three products of inertia on lattices of their own. Densities come
from sums, so a lattice may be laid anew at any time and nothing is interpolated.

The residual's variance is what the data say, never less than what is trusted: a sample that does
not fit widens every candidate's error, and where that raises the entropy more than the sample
lowers it, the sample does not count (eq. 9). The wider variance stays, so a lasting contradiction
comes to count; and after LOCKED seconds of motion in which nothing counted everything does, so
the gate can't lock the filter on a wrong peak.
"""

from dataclasses import dataclass

import numpy as np

from .beside_bayes import BesideBayes
from .histogram import Histogram, entropy_of, normalised
from .method import joined_state, part_of
from .regression import moves

# A step of 1.4 standard deviations at most: on a coarser lattice the entropy also changes with
# where between candidates the peak lies, and the gate would refuse for that.
POINTS = 7
# Lattices laid for one sample at most; the first samples narrow the peak a hundredfold.
ROUNDS = 3
# The residual's variance remembers this much motion [s] plus its age so many times over.
SCALE_MEMORY, AGES = 30.0, 4.0
LARGEST_RATIO = 100.0
LOCKED = 0.5
# The inertia's lattices are laid this many samples apart: they narrow over seconds.
INERTIA_EVERY = 5
MOMENTS, PRODUCTS_OF_INERTIA = [0, 3, 5], [1, 2, 4]


@dataclass(frozen=True)
class ResidualScale:
    """
    How many times wider the residual's variance is than stated; at least 1.

    age [s]: motion it has seen.
    """

    value: float = 1.0
    age: float = 0.0

    def after(self, ratio, dt):
        """Return the ResidualScale after a sample with that squared ratio of error to expected."""
        age = self.age + dt
        step = dt / (SCALE_MEMORY + AGES * age)
        return ResidualScale(max(1.0, self.value + step * (ratio - self.value)), age)


class GpHistogram(BesideBayes):
    """
    Estimate the load as the mean of candidates' probabilities.

    refused: samples that raised the entropy and did not count.
    """

    name = 'gp_histogram'

    def __init__(self, model, uncertainties, function):
        self._variance = model.residuals.rmse ** 2
        super().__init__(model, uncertainties, function)

    def _restart(self):
        mean, std = self._prior.mean, self._prior.std
        self._places = Histogram(mean[:4], std[:4], POINTS)
        self._inertias = [(where, Histogram(mean[4:][where], std[4:][where], POINTS))
                          for where in (MOMENTS, PRODUCTS_OF_INERTIA)]
        self._scale, self.refused = ResidualScale(), 0
        self._shut, self._count = 0.0, 0
        self._renew()

    @property
    def entropy(self):
        """H over the candidates of mass and centre of mass (E6.3)."""
        return self._places.entropy

    @property
    def reliability(self):
        """What the histogram says of its answer (E2.3, E6.3), by name."""
        return {'entropy [nat]': self.entropy,
                'largest probability': float(self._places.probabilities.max()),
                **{f'most probable {name}': float(value) for name, value in
                   zip(('mass [kg]', 'x [m]', 'y [m]', 'z [m]'), self._places.best)}}

    def _take(self, sample, prediction, columns):
        weights = sample.dt / prediction.counted
        moving = moves(sample, prediction)
        if moving and not self._opens(sample, prediction, columns, weights):
            self.refused += 1
        else:
            self._counted.add(sample, columns, prediction.difference, weights, moving)
        self._count += 1
        self._renew()

    def _opens(self, sample, prediction, columns, weights):
        """Tell whether a sample counts, and note how well it fits."""
        expected = self._plain.factor * (self._variance + self._plain.spread + prediction.stuck)
        ratio = min(float(np.mean(self._plain.innovation ** 2 / expected)), LARGEST_RATIO)
        scale = self._scale.after(ratio, sample.dt)
        lowered = self._entropy_with(prediction, columns, weights, scale.value) < self.entropy
        self._scale = scale
        self._shut = 0.0 if lowered else self._shut + sample.dt
        return lowered or self._shut > LOCKED

    def _entropy_with(self, prediction, columns, weights, scale):
        """Return H over the lattice were the sample counted at that scale."""
        rest = prediction.difference - columns[:, 10:] @ self._plain.nuisances \
            - prediction.load_columns @ self.tared
        error = rest - self._products @ prediction.load_columns.T
        sample = -0.5 * (error * error) @ weights
        return entropy_of(normalised(self._data * (self._scale.value / scale) + sample / scale
                                     + self._from_prior))

    def _renew(self):
        posterior = self._posterior(self._places.mean[0])
        for _ in range(ROUNDS):
            self._weigh(posterior)
            if not self._places.refine():
                break
        else:
            self._weigh(posterior)
        if self._count % INERTIA_EVERY == 0:
            self._renew_inertia(posterior.inertia_given(self._places.mean, self._scale.value))

    def _weigh(self, posterior):
        self._see_candidates(posterior)
        density = posterior.log_density(self._places.candidates, self._products,
                                        self._scale.value)
        with np.errstate(invalid='ignore'):
            self._data = np.nan_to_num(density - self._from_prior, nan=0.0)
        self._places.weigh(density)

    def _see_candidates(self, posterior):
        """Note what is the candidates' own, whatever the data say."""
        candidates = self._places.candidates
        self._products = posterior.products(candidates)
        away = (candidates - self._prior.mean[:4]) / self._prior.std[:4]
        self._from_prior = np.where(candidates[:, 0] < 0.0, -np.inf, -0.5 * (away ** 2).sum(-1))

    def _renew_inertia(self, given):
        """Weigh moments with the products of inertia at their mean, then the other way round."""
        inertia, self._slope = self._inertia_mean(), given.slope
        for where, histogram in self._inertias:
            for _ in range(ROUNDS):
                histogram.weigh(given.log_density(histogram.candidates, where, inertia))
                if not histogram.refine():
                    break
            else:
                histogram.weigh(given.log_density(histogram.candidates, where, inertia))
            inertia[where] = histogram.mean

    def _inertia_mean(self):
        out = np.empty(6)
        for where, histogram in self._inertias:
            out[where] = histogram.mean
        return out

    def _found(self):
        (_, moments), (_, products) = self._inertias
        gate = self._scale.value, self._scale.age, self._shut, self.refused, self._count
        return {**joined_state(places=self._places.state(), moments=moments.state(),
                               products=products.state()),
                'data': self._data, 'slope': self._slope, 'gate': np.array(gate, dtype=float)}

    def _resume(self, found):
        (_, moments), (_, products) = self._inertias
        self._places.restore(part_of(found, 'places'))
        moments.restore(part_of(found, 'moments'))
        products.restore(part_of(found, 'products'))
        self._data, self._slope = found['data'], found['slope']
        value, age, self._shut, refused, count = found['gate'].tolist()
        self._scale = ResidualScale(value, age)
        self.refused, self._count = int(refused), int(count)
        self._see_candidates(self._posterior(self._places.mean[0]))

    def _answer(self):
        place, covariance = self._places.belief()
        inertia_covariance = np.zeros((6, 6))
        for where, histogram in self._inertias:
            inertia_covariance[np.ix_(where, where)] = histogram.belief()[1]
        return self._joined(place, covariance, self._inertia_mean(), inertia_covariance,
                            self._slope)
