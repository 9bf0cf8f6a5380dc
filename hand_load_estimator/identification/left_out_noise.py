"""
What recordings left out of a fit tell of the noise that its model is to state.

What is left of a recording that the fit has not seen is noise; what offset and friction are there
that they are not elsewhere (drift); and what the parameters do, of covariance C, that were found
without it. The model states each by itself, so none may make the density larger than it is within
the fit. There drift counts, on purpose: of arms that do more than drift (measured ones) a density
beside freely drifting friction is too small (doc/method.md, "How wide the intervals are").
"""

import numpy as np

from .block_means import all_blocks
from .load_agreement import pieces_of
from .regression_system import held_out
from .residual_noise import density

# Fewest rows of a joint in motion that are fitted.
FEWEST_ROWS = 50


def noise_left_out(system, prior, weights, friction):
    """
    Return density (n,) [Nm^2 s] and drift (n, 3) that a System's residual is to have in its model.

    prior: mean and covariance before the fit; weights (N, n) of a fit without drift; friction
    (n,): levels that stuck joints may hold. The density within the fit grows by the factor by
    which squared means over blocks, of recordings left out, are larger than it, drift and C
    foretell (at least 1). Blocks of which it foretells little tell little of it.
    """
    x, _ = system.solve(*prior, weights)
    inside = density(system.residual(x), weights, system.owner, system.dt)
    # C is stated beside the density, so it has to be of fits that know no other.
    weights = system.weights(inside, friction)
    left_out = held_out(system, *prior, weights)
    drift = drift_of(system, left_out, weights)
    more = np.ones(len(inside))
    for blocks in all_blocks(weights, pieces_of(system, left_out), system.dt):
        noise = np.maximum(inside / blocks.length, 1e-300)
        stated = (noise + _of_drift(blocks, system, drift)
                  + _of_parameters(blocks, system, left_out))
        squares = blocks.means(left_out.residual) ** 2
        more = np.maximum(more, blocks.average(squares / stated, noise / stated))
    return inside * more, drift


def _of_drift(blocks, system, drift):
    """Return the variance (B, n) that drift (n, 3) gives to means over blocks."""
    state, velocity = (blocks.means(values) for values in system.drifting)
    return (drift[:, 0] ** 2 + (state * drift[:, 1]) ** 2 + (velocity * drift[:, 2]) ** 2)


def _of_parameters(blocks, system, left_out):
    """Return y C y^T (B, n) of the means y of columns over blocks, C of what each is part of."""
    part = blocks.first(left_out.part)
    out = np.empty((len(part), system.torque.shape[1]))
    for j in range(out.shape[1]):
        y = blocks.means_for(j, system.columns[:, j])
        for number, covariance in left_out.covariances.items():
            own = part == number
            out[own, j] = ((y[own] @ covariance) * y[own]).sum(axis=1)
    return out


def drift_of(system, left_out, weights):
    """
    Return the std (n, 3) between recordings of offset, Coulomb level and viscous coefficient.

    What is left of recordings left out is fitted by the three; how they spread, less what noise
    and the parameters found without them explain, is what changes from day to day. Each is
    halved, which shows how it changes with time; a single recording has been cut into parts.
    """
    single = len(np.unique(system.recording)) == 1
    groups = []
    for part in left_out.covariances:
        rows = np.flatnonzero(left_out.part == part)
        groups += [own for own in np.array_split(rows, 1 if single else 2)
                   if len(own) > FEWEST_ROWS]
    return np.array([_drift_of_joint(system, left_out, weights, groups, j)
                     for j in range(weights.shape[1])])


def _drift_of_joint(system, left_out, weights, groups, j):
    fits, noise, errors = [], [], []
    for rows in groups:
        moving = rows[np.abs(system.velocity[rows, j]) > 0.02]
        if len(moving) < FEWEST_ROWS:
            continue
        y = np.stack([np.ones(len(moving)),
                      *(values[moving, j] for values in system.drifting)], axis=1)
        weighted = (y * weights[moving, j, None]).T
        covariance = np.linalg.inv(weighted @ y + 1e-9 * np.eye(3))
        fits.append(covariance @ (weighted @ left_out.residual[moving, j]))
        through = covariance @ (weighted @ system.columns[moving, j])
        noise.append(np.diag(covariance))
        errors.append(noise[-1] + ((
            through @ left_out.covariances[left_out.part[rows[0]]]) * through).sum(axis=1))
    if not fits:
        return np.zeros(3)
    # Moment estimate of a random effect around zero, each fit weighed by its precision. Of the
    # noise in fits a quarter stays as what this many cannot exclude; what the parameters may be
    # off by is stated with them.
    precision = 1.0 / np.array(errors)
    excess = ((np.square(fits) * precision).sum(axis=0) - len(fits)) / precision.sum(axis=0)
    return np.sqrt(np.maximum(excess, 0.25 * len(fits) / (1.0 / np.array(noise)).sum(axis=0)))
