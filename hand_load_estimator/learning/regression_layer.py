"""
The recursive regression as a torch layer, batched and differentiable.

The same mathematics as estimators/information.py (a test compares them): sums of weighted
normal equations, marginalisation of the model's nuisances, Gauss-Newton with the prior in shape
parameters. Gradients reach the corrections a network puts on every sample.
"""

import torch

_TENSOR = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
STEPS = 5


def chunk_sums(columns, difference, weights, size):
    """
    Return matrix (B, T / size, d, d) and vector (B, T / size, d): information up to each chunk.

    columns (B, T, n, d); difference, weights (B, T, n).
    """
    b, t, n, d = columns.shape
    rows = columns.reshape(b, t // size, size * n, d)
    weighted = rows * weights.reshape(b, t // size, size * n, 1)
    matrix = weighted.transpose(-1, -2) @ rows
    vector = (weighted.transpose(-1, -2) @ difference.reshape(
        b, t // size, size * n, 1)).squeeze(-1)
    return matrix.cumsum(dim=1), vector.cumsum(dim=1)


def marginal(matrix, vector):
    """Return the load's share (..., 10, 10), (..., 10) with unit-variance nuisances gone."""
    inner = matrix[..., 10:, 10:] + torch.eye(matrix.shape[-1] - 10, dtype=matrix.dtype,
                                              device=matrix.device)
    factor = torch.linalg.cholesky(inner)
    right = torch.cat([matrix[..., 10:, :10], vector[..., 10:, None]], dim=-1)
    solved = torch.cholesky_solve(right, factor)
    cross = matrix[..., :10, 10:] @ solved
    return matrix[..., :10, :10] - cross[..., :10], vector[..., :10] - cross[..., 10]


def products_of_shape(shape):
    """Return products (..., 10) and their Jacobian (..., 10, 10) of shape parameters."""
    m, c, g = shape[..., 0], shape[..., 1:4], shape[..., 4:]
    cc = (c * c).sum(dim=-1)
    zero, one = torch.zeros_like(m), torch.ones_like(m)
    rows, values = [[one] + [zero] * 9], [m]
    for i in range(3):
        row = [c[..., i]] + [zero] * 9
        row[1 + i] = m
        rows.append(row)
        values.append(m * c[..., i])
    second = {}
    for k, (i, j) in enumerate(_TENSOR):
        per_mass = g[..., k] + (cc if i == j else zero) - c[..., i] * c[..., j]
        row = [per_mass] + [zero] * 9
        for axis in range(3):
            slope = (2.0 * c[..., axis] if i == j else zero) \
                - (c[..., j] if i == axis else zero) - (c[..., i] if j == axis else zero)
            row[1 + axis] = m * slope
        row[4 + k] = m
        second[i, j] = (m * per_mass, row)
    # pinocchio's order of the second moments
    for ij in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)):
        values.append(second[ij][0])
        rows.append(second[ij][1])
    jacobian = torch.stack([torch.stack(row, dim=-1) for row in rows], dim=-2)
    return torch.stack(values, dim=-1), jacobian


def shape_posterior(matrix, vector, prior_mean, prior_std, start=None):
    """Return shape (..., 10) and covariance; gradients flow through the last step only."""
    with torch.no_grad():
        shape = prior_mean.expand(vector.shape) if start is None else start
        for _ in range(STEPS - 1):
            shape = shape + _newton(matrix, vector, shape, prior_mean, prior_std)[0]
    step, covariance = _newton(matrix, vector, shape, prior_mean, prior_std)
    return shape + step, covariance


def _newton(matrix, vector, shape, prior_mean, prior_std):
    products, jacobian = products_of_shape(shape)
    misfit = vector - (matrix @ products[..., None]).squeeze(-1)
    gradient = (jacobian.transpose(-1, -2) @ misfit[..., None]).squeeze(-1)
    gradient = gradient + (prior_mean - shape) / prior_std ** 2
    curvature = jacobian.transpose(-1, -2) @ matrix @ jacobian
    scaled = curvature * prior_std * prior_std[..., None] + torch.eye(
        10, dtype=matrix.dtype, device=matrix.device)
    inverse = torch.linalg.inv(0.5 * (scaled + scaled.transpose(-1, -2)))
    step = prior_std * (inverse @ (prior_std * gradient)[..., None]).squeeze(-1)
    return step, inverse * prior_std * prior_std[..., None]


def message_moments(shape, covariance):
    """Return mean and variance (..., 10) in message order of a shape belief."""
    m, g = shape[..., :1], shape[..., 4:]
    variance = torch.diagonal(covariance, dim1=-2, dim2=-1)
    inertia = (m ** 2 * variance[..., 4:] + g ** 2 * variance[..., :1]
               + 2.0 * m * g * covariance[..., 0, 4:] + variance[..., :1] * variance[..., 4:])
    mean = torch.cat([shape[..., :4], m * g], dim=-1)
    return mean, torch.cat([variance[..., :4], inertia], dim=-1)
