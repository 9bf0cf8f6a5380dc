"""Several recordings in lock-step, so that a step costs one call for all of them."""

import numpy as np


def side_by_side(parts):
    """
    Return arrays (L, sum of k) of parts' arrays (N, k), the parts beside one another.

    L: rows of the longest part; shorter ones stay where they ended.
    """
    longest = max(len(part[0]) for part in parts)
    return [np.hstack([np.pad(rows, ((0, longest - len(rows)), (0, 0)), 'edge') for rows in own])
            for own in zip(*parts)]
