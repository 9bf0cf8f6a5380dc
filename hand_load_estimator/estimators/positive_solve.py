"""
Solve with symmetric positive matrices of the sizes that occur at every sample.

At six to forty unknowns numpy.linalg spends more on its wrapping than on the arithmetic.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg.lapack import dposv


def positive_solve(matrix, right):
    """
    Return X of matrix (k, k) X = right, (k,) or (k, m); only one triangle of the matrix counts.

    Raises numpy.linalg.LinAlgError where the matrix is singular.
    """
    _, solved, failed = dposv(matrix, right)
    # What rounding has made indefinite still has a solution.
    return np.linalg.solve(matrix, right) if failed else solved


@lru_cache
def unit(k):
    """Return the identity (k, k), not to be written to."""
    out = np.eye(k)
    out.setflags(write=False)
    return out
