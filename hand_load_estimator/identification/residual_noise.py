"""What identification leaves: its density, its size in sliding, its drift between recordings."""

import numpy as np

from ..torque_model import WARMED

# Lengths [s] of the block means from which the residual's density is read.
BLOCK_MEANS = (0.06, 0.2, 0.5, 1.0)
FEWEST_BLOCKS = 8
# Smallest residual believed, as a fraction of the joint's maximum torque.
LEAST_NOISE = 1e-4
# Shares by which offset, Coulomb level and viscous coefficient of one day differ from another's
# [standard deviations] where no temperature is known: viscous friction falls by a third to a half
# from a cold joint to a warm one, Coulomb's changes little (Bittencourt et al. 2010).
USUAL_DRIFT = np.array([0.0, 0.05, 0.2])


def density(residual, weights, owner, dt):
    """
    Return the residual's low-frequency density (n,) [Nm^2 s] from means over blocks.

    A block's mean has variance density / length when the block is longer than the residual's
    memory, less when it is shorter; the largest product over BLOCK_MEANS is the safe one.
    """
    best = np.zeros(residual.shape[1])
    for blocks in _blocks(weights, owner, dt):
        best = np.maximum(best, blocks.mean_of(blocks.means(residual) ** 2) * blocks.length)
    return best


def density_left_out(inside, system, left_out, weights):
    """
    Return the density (n,) [Nm^2 s] that a LeftOut of a System shows, of weights (N, n).

    inside (n,): that of the residual within the fit. What was left out is off by as much, and by
    what the parameters do that were found without it: a block's mean has variance
    inside / length + y C y^T. C is stated beside the density and must not count twice, so only
    the factor counts by which squared means are larger than that, on average over blocks, C being
    in proportion to inside.
    """
    more = np.ones(len(inside))
    for blocks in _blocks(weights, system.owner, system.dt):
        squares = blocks.means(left_out.residual) ** 2
        part = blocks.first(left_out.part)
        for j in range(len(inside)):
            y = blocks.means(system.columns[:, j], j)
            stated = inside[j] / blocks.length + _spread(y, part, left_out.covariances)
            more[j] = max(more[j], blocks.mean_of(squares[:, j] / np.maximum(stated, 1e-300), j))
    return inside * more


def _spread(y, part, covariances):
    """Return y C y^T (B,) of rows y (B, P), with the covariance C of the part of each."""
    out = np.zeros(len(y))
    for number, covariance in covariances.items():
        own = part == number
        out[own] = ((y[own] @ covariance) * y[own]).sum(axis=1)
    return out


class _Blocks:
    """Blocks of so many rows each, those in one recording; length [s]: of a block."""

    def __init__(self, weights, owner, size, period):
        self.length = size * period
        self._count, self._size = len(weights) // size, size
        self._weights = self._cut(weights)
        self._total = self._weights.sum(axis=1)
        own = self._cut(owner)
        self._worth = self._total * (own == own[:, :1]).all(axis=1)[:, None]

    def _cut(self, rows):
        return rows[:self._count * self._size].reshape(self._count, self._size, *rows.shape[1:])

    def first(self, rows):
        """Return the first of each block's rows (N,)."""
        return self._cut(rows)[:, 0]

    def means(self, values, joint=None):
        """Return weighted means of values (N, n); with a joint, of values (N, k) at its weights."""
        if joint is None:
            return (self._weights * self._cut(values)).sum(axis=1) / np.maximum(self._total, 1e-30)
        return np.einsum('bs,bsk->bk', self._weights[:, :, joint], self._cut(values)) \
            / np.maximum(self._total[:, joint, None], 1e-30)

    def mean_of(self, values, joint=slice(None)):
        """Return the mean over blocks of values (B, n), or (B,) of a joint, by their weights."""
        worth = self._worth[:, joint]
        return (worth * values).sum(axis=0) / np.maximum(worth.sum(axis=0), 1e-30)


def _blocks(weights, owner, dt):
    """Yield _Blocks of each of BLOCK_MEANS of which there are enough."""
    period = float(np.median(dt))
    for length in BLOCK_MEANS:
        size = max(1, round(length / period))
        if len(weights) // size < FEWEST_BLOCKS:
            return
        yield _Blocks(weights, owner, size, period)


def rmse_of(model, system, residual, moved):
    """
    Return the RMS (n,) [Nm] of a residual (N, n) of a System while joints surely slide.

    Joints that are not among `moved` (n,) show how they stand only; they may leave as much more
    as a TorqueModel identified from the System does not know of their friction.
    """
    slides = (system.doubt < 0.1) & (np.abs(system.z) > 0.9)
    shown = np.where(moved, slides, True) & system.tells
    rmse = np.sqrt((shown * residual ** 2).sum(axis=0) / np.maximum(shown.sum(axis=0), 1))
    unknown = np.where(moved, 0.0, model.friction_doubt())
    return np.maximum(np.hypot(rmse, unknown), LEAST_NOISE * model.robot.limits.torque)


def drift_of(system, left_out, weights):
    """
    Return the std (n, 3) between recordings of offset, Coulomb level and viscous coefficient.

    What is left of each recording left out is fitted by the three; the spread over recordings,
    less what noise and the parameters found without it explain, is what changes from day to day.
    Recordings are halved, so that one alone also shows how it changes with time.
    """
    groups = []
    for k in np.unique(system.recording):
        rows = np.flatnonzero(system.recording == k)
        groups += [half for half in np.array_split(rows, 2) if len(half) > 50]
    return np.array([_drift_of_joint(system, left_out, weights, groups, j)
                     for j in range(weights.shape[1])])


def _drift_of_joint(system, left_out, weights, groups, j):
    fits, errors = [], []
    for rows in groups:
        moving = rows[np.abs(system.velocity[rows, j]) > 0.02]
        if len(moving) < 50:
            continue
        y = np.stack([np.ones(len(moving)),
                      *(values[moving, j] for values in system.drifting)], axis=1)
        weighted = (y * weights[moving, j, None]).T
        covariance = np.linalg.inv(weighted @ y + 1e-9 * np.eye(3))
        fits.append(covariance @ (weighted @ left_out.residual[moving, j]))
        through = covariance @ (weighted @ system.columns[moving, j])
        errors.append(np.diag(covariance) + ((
            through @ left_out.covariances[left_out.part[rows[0]]]) * through).sum(axis=1))
    if not fits:
        return np.zeros(3)
    # Moment estimate of a random effect around zero, each fit weighed by its precision; a quarter
    # of the fits' own error stays as what this many fits cannot exclude.
    precision = 1.0 / np.array(errors)
    total = precision.sum(axis=0)
    excess = ((np.square(fits) * precision).sum(axis=0) - len(fits)) / total
    return np.sqrt(np.maximum(excess, 0.25 * len(fits) / total))


def known_joints(evidence):
    """Tell of which joints (n,) a list of Evidence knows the temperature most of the time."""
    return np.isfinite(np.concatenate([e.motion.temperature for e in evidence])).mean(axis=0) > 0.5


def with_usual_drift(model, system, drift, told):
    """
    Return the drift (n, 3) that a model is to state of which a System shows so much.

    model: a TorqueModel identified from the System; told (n,): joints whose temperature is known.
    Few recordings show little of how friction differs from day to day: where no effect of a known
    temperature tells that, USUAL_DRIFT counts as one of them. Nothing less than seen is stated.
    """
    recordings = len(np.unique(system.recording))
    figures = np.stack([np.zeros(model.robot.n), model.friction_level(),
                        model.viscous_friction()], axis=1)
    mixed = np.sqrt(((recordings - 1) * drift ** 2 + (USUAL_DRIFT * figures) ** 2) / recordings)
    for use in model.uses:
        if use.name in WARMED and told[use.joint]:
            mixed[use.joint, WARMED[use.name]] = 0.0
    return np.maximum(drift, mixed)
