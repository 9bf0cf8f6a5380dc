"""Shares of counted cases, with what so few cases leave open."""

import numpy as np

_Z = 1.959964  # of a normal distribution, two-sided 95 %


def wilson(count, cases):
    """Return the ends of Wilson's 95 % interval for a share of which `count` of `cases` were."""
    share, z2 = count / cases, _Z ** 2 / cases
    middle = (share + 0.5 * z2) / (1.0 + z2)
    half = np.sqrt(share * (1.0 - share) * z2 + 0.25 * z2 ** 2) / (1.0 + z2)
    return float(max(middle - half, 0.0)), float(min(middle + half, 1.0))


def share_text(count, cases):
    """Return a share in per cent with its counts and Wilson's 95 % interval."""
    low, high = wilson(count, cases)
    return (f'{100.0 * count / cases:.1f} % ({count} of {cases}; 95 % interval '
            f'{100.0 * low:.1f} to {100.0 * high:.1f} %)')
