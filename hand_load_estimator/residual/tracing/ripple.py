"""Find the periods of a ripple in the residual: no list, a spectrum over position."""

import numpy as np

from ...effects.torque_ripple import waves
from ...motion import BANDWIDTH

LOWEST, HIGHEST = 4.0, 400.0   # [1/turn]
CANDIDATES = 3
# A ripple faster than this [rad/s] does not come through the motion filter.
FASTEST = 250.0
# A peak is refined so often, with so many periods near it each time.
TURNS, NEAR = 3, 9


def likely_periods(q, v, residual, weights):
    """
    Return periods per turn (<= CANDIDATES,) that explain most of a residual, and of how many.

    q [rad], v [rad/s], residual [Nm], weights, (N,) each. Empty where the joint hardly moves.
    """
    span = float(np.ptp(q))
    if span < 0.05:
        return np.zeros(0), 0
    step = 0.25 * 2.0 * np.pi / span
    lowest = max(LOWEST, 3.0 * 2.0 * np.pi / span)
    grid = np.arange(lowest, HIGHEST, step)
    power = _spectrum(q, v, residual, weights, grid, step)
    peaks = [k for k in range(1, len(grid) - 1)
             if power[k] >= power[k - 1] and power[k] > power[k + 1]]
    best = sorted(peaks, key=lambda k: -power[k])[:CANDIDATES]
    # The grid is four times finer than periods are told apart; what refines a peak counts whole.
    return (np.array([_refined(q, v, residual, weights, grid[k], step) for k in best]),
            len(grid) // 4 + len(best) * TURNS * NEAR)


def _spectrum(q, v, residual, weights, grid, step):
    """Return what _explained says of every period of a grid, `step` apart."""
    # As _wave has it. Sines are the costly part: on an even grid one product stands for both.
    shown = q + 3.0 / BANDWIDTH * v
    wave, turn = np.exp(1j * grid[0] * shown), np.exp(1j * step * shown)
    power = np.empty(len(grid))
    for k, periods in enumerate(grid):
        late = 1.0 + 1j * periods / BANDWIDTH * v
        power[k] = _explained(wave / (late * late * late), v, residual, weights, periods)
        wave = wave * turn
    return power


def _explained(wave, v, residual, weights, periods):
    """Return the weighted squares that a sine of this period takes off; wave: cosine + i sine."""
    weighted = wave * (weights * (np.abs(periods * v) < FASTEST))
    size, square = np.vdot(wave, weighted).real, weighted @ wave
    along = weighted @ residual
    determinant = size * size - abs(square) ** 2
    if determinant <= 1e-9 * size * size:
        return 0.0
    return 2.0 * (size * abs(along) ** 2 - (np.conj(square) * along * along).real) / determinant


def _refined(q, v, residual, weights, periods, step):
    """Return the best period near a peak of the grid."""
    for _ in range(TURNS):
        near = periods + step * np.linspace(-1.0, 1.0, NEAR)
        periods = near[np.argmax([_explained(_wave(q, v, p), v, residual, weights, p)
                                  for p in near])]
        step /= 4.0
    return periods


def _wave(q, v, periods):
    sine, cosine = waves(q, v, periods)
    return cosine + 1j * sine
