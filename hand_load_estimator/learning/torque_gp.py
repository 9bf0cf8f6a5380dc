"""
Gaussian process regression of the no-load torque difference, one process per joint (E2.1, eq. 8).

Thousands of samples by inducing points: kernel, noise and the points' places maximise gpytorch's
variational bound of the marginal likelihood, in which a sample counts by its worth; the posterior
at the points then has a closed form.
"""

import gpytorch
import numpy as np
import torch

from ..estimators.inducing_points import InducingPoints, matern
from .left_out import left_out

POINTS, STEPS, BATCH, RATE = 32, 150, 512, 0.05
# Natural gradients of the points' posterior: a step of 1 on all data would end at its optimum.
NATURAL_RATE = 0.3
JITTER = 1e-6


class _Processes(gpytorch.models.ApproximateGP):
    """A batch of n independent processes with zero mean: the torque model is the mean."""

    def __init__(self, points):
        n, count, width = points.shape
        batch = torch.Size([n])
        super().__init__(gpytorch.variational.VariationalStrategy(
            self, points,
            gpytorch.variational.NaturalVariationalDistribution(count, batch_shape=batch)))
        self.mean_module = gpytorch.means.ZeroMean(batch_shape=batch)
        self.covar_module = gpytorch.kernels.ScaleKernel(
            gpytorch.kernels.MaternKernel(nu=2.5, ard_num_dims=width, batch_shape=batch),
            batch_shape=batch)
        self.covar_module.outputscale = 0.1

    def forward(self, x):
        """Return the prior at x (n, N, D)."""
        return gpytorch.distributions.MultivariateNormal(self.mean_module(x),
                                                         self.covar_module(x))


def learn_gp(data, seed, write=lambda text: None):
    """Return (tensors of InducingPoints, LeftOut) for DifferenceData."""
    kernel = learn_kernel(data, seed, write)
    everything = np.ones(len(data.dt), dtype=bool)
    return (process_posterior(data, kernel, everything),
            left_out(data, lambda rows: InducingPoints(process_posterior(data, kernel, rows)).at))


def learn_kernel(data, seed, write):
    """Return {name: array} of the largest bound: points, lengthscale, outputscale, noise."""
    count, n, _ = data.inputs.shape
    rng = np.random.default_rng(seed)
    first = np.stack([data.inputs[rng.choice(count, min(POINTS, count), replace=False), j]
                      for j in range(n)])
    x, y, worth = (torch.tensor(np.swapaxes(part, 0, 1)) for part in
                   (data.inputs, data.difference, data.worth))
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        model = _Processes(torch.tensor(first)).double()
        likelihood = gpytorch.likelihoods.GaussianLikelihood(
            batch_shape=torch.Size([n])).double()
        natural = gpytorch.optim.NGD(model.variational_parameters(), count, NATURAL_RATE)
        optimiser = torch.optim.Adam([*model.hyperparameters(), *likelihood.parameters()], RATE)
        for step in range(STEPS):
            rows = torch.tensor(rng.choice(count, min(BATCH, count), replace=False))
            optimiser.zero_grad()
            natural.zero_grad()
            fit = likelihood.expected_log_prob(y[:, rows], model(x[:, rows]))
            bound = (worth[:, rows] * fit).sum(-1) * (count / len(rows)) \
                - model.variational_strategy.kl_divergence()
            (-bound.sum() / count).backward()
            optimiser.step()
            natural.step()
            if (step + 1) % 50 == 0:
                write(f'step {step + 1} of {STEPS}: bound {float(bound.detach().sum()):.0f} nats')
    covariance = model.covar_module
    return {name: value.detach().numpy() for name, value in (
        ('points', model.variational_strategy.inducing_points),
        ('lengthscale', covariance.base_kernel.lengthscale[:, 0]),
        ('outputscale', covariance.outputscale), ('noise', likelihood.noise[:, 0]))}


def process_posterior(data, kernel, rows):
    """Return the tensors of InducingPoints of a kernel after the rows (N,) bool of the data."""
    rate = np.sqrt(5.0) / kernel['lengthscale']
    places = kernel['points'] * rate[:, None]
    level = kernel['outputscale']
    prior = matern(places, places.swapaxes(0, 1)[:, :, None], level).swapaxes(0, 1)
    prior += JITTER * level[:, None, None] * np.eye(places.shape[1])
    to_data = matern(places, (data.inputs[rows] * rate)[:, :, None], level)
    precision = data.worth[rows] / kernel['noise']
    weighted = to_data * precision[..., None]
    after = prior + np.einsum('knm,knl->nml', weighted, to_data)
    vector = np.einsum('knm,kn->nm', weighted, data.difference[rows])
    return {**{name: kernel[name] for name in ('points', 'lengthscale', 'outputscale')},
            'mean_weights': np.linalg.solve(after, vector[..., None])[..., 0],
            'shrink': np.linalg.inv(prior) - np.linalg.inv(after)}
