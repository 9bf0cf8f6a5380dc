"""
Methods `gp_swarm`, `gp_evolution`, `gp_annealing`: a search for the best load (E2.7).

In place of the histogram a library looks for the mass and centre of mass with the largest
posterior density, at intervals and over all data so far; the inertia comes by its normal density
given them. The variance is that of the density's curvature there and of half the last step, along
which the next search looks further, too: one that ended short goes on. So the first search's long
way counts as doubt until the second. It is the same on every run.
"""

import numpy as np
from scipy.optimize import differential_evolution, dual_annealing

from .beside_bayes import BesideBayes
from .regression import moves

# Searches follow each other after so much motion [s]: quickly at first, when most is learnt.
EARLY, INTERVAL, EARLY_FOR = 0.1, 0.5, 1.0
# Standard deviations that a search looks away from where the last one ended.
REACH = 6.0
SEED = 1


class GpSearch(BesideBayes):
    """
    Estimate the load as the best point a search finds; subclasses bring the search.

    _search(cost) returns the best u (4,) in [-1, 1]; cost (N, 4) -> (N,) nats above the start's.
    """

    def _restart(self):
        prior = self._prior
        self._place, self._covariance = prior.mean[:4], np.diag(prior.std[:4] ** 2)
        self._moved, self._next = 0.0, EARLY
        # Renews the sums, too, that the doubt about torque constants is counted from.
        self._counted.load_information()
        self._answered = self._joined(self._place, self._covariance, prior.mean[4:],
                                      np.diag(prior.std[4:] ** 2), np.zeros((6, 4)))

    def _take(self, sample, prediction, columns):
        moving = moves(sample, prediction)
        self._counted.add(sample, columns, prediction.difference,
                          sample.dt / prediction.counted, moving)
        self._moved += sample.dt if moving else 0.0

    def settle(self):
        """Look for a load change, and search where it is time to."""
        super().settle()
        if self._moved < self._next:
            return
        self._next = self._moved + (EARLY if self._moved < EARLY_FOR else INTERVAL)
        posterior = self._posterior(self._place[0])
        axes = REACH * np.linalg.cholesky(self._covariance)
        start = posterior.log_density(self._place[None])

        def cost(u):
            density = posterior.log_density(self._place + u @ axes.T)
            return np.minimum(start - density, 1e9)

        found = self._place + axes @ self._search(cost)
        half, self._place = 0.5 * (found - self._place), found
        self._covariance = posterior.curvature(found) + np.outer(half, half)
        given = posterior.inertia_given(found)
        self._answered = self._joined(found, self._covariance, given.mean, given.covariance,
                                      given.slope)

    def _found(self):
        shape, covariance = self._answered
        return {'shape': shape, 'covariance': covariance, 'place_covariance': self._covariance,
                'moved': np.array(self._moved), 'next': np.array(self._next)}

    def _resume(self, found):
        self._answered = found['shape'], found['covariance']
        self._place, self._covariance = found['shape'][:4], found['place_covariance']
        self._moved, self._next = float(found['moved']), float(found['next'])

    def _answer(self):
        return self._answered


class GpEvolution(GpSearch):
    """Differential evolution, scipy's genetic algorithm for real numbers."""

    name = 'gp_evolution'

    def _search(self, cost):
        return differential_evolution(
            lambda u: cost(u.T), [(-1.0, 1.0)] * 4, popsize=10, maxiter=30, vectorized=True,
            updating='deferred', polish=False, x0=np.zeros(4), rng=SEED).x


class GpAnnealing(GpSearch):
    """Simulated annealing in scipy's generalised form."""

    name = 'gp_annealing'

    def _search(self, cost):
        return dual_annealing(lambda u: float(cost(u[None])[0]), [(-1.0, 1.0)] * 4, maxiter=100,
                              no_local_search=True, x0=np.zeros(4), rng=SEED).x


class GpSwarm(GpSearch):
    """Particle swarm of evox, which runs on torch."""

    name = 'gp_swarm'
    PARTICLES, STEPS = 40, 30

    def __init__(self, *arguments):
        super().__init__(*arguments)
        # Loading torch takes seconds: only who asks for a swarm waits, and before the arm moves.
        _swarm_library()

    def _search(self, cost):
        torch, PSO, Problem, StdWorkflow = _swarm_library()

        class Density(Problem):
            """The cost as evox calls it."""

            def evaluate(self, pop):
                return torch.tensor(cost(pop.numpy().astype(float)), dtype=pop.dtype)

        with torch.random.fork_rng(), torch.no_grad():
            torch.manual_seed(SEED)
            swarm = PSO(self.PARTICLES, -torch.ones(4), torch.ones(4), device=torch.device('cpu'))
            workflow = StdWorkflow(swarm, Density())
            workflow.init_step()
            for _ in range(self.STEPS):
                workflow.step()
        return swarm.global_best_location.numpy().astype(float)


def _swarm_library():
    import torch
    from evox.algorithms import PSO
    from evox.core import Problem
    from evox.workflows import StdWorkflow
    return torch, PSO, Problem, StdWorkflow
