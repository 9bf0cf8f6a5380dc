"""Recordings in lock-step: each is followed as if it were alone, and none pays for another."""

import numpy as np

from hand_load_estimator.torque.lock_step import lock_step


def sums(numbers, rows):
    """Return running sums of both arrays (L, k of all)."""
    first, second = rows
    return np.cumsum(first, axis=0) + np.repeat(second, first.shape[1] // second.shape[1], axis=1)


def test_each_part_is_followed_as_if_it_were_alone():
    rng = np.random.default_rng(0)
    parts = [(rng.normal(size=(count, 2)), rng.normal(size=(count, 1)))
             for count in (50, 1, 30, 200, 120)]
    for (first, second), found in zip(parts, lock_step(parts, sums), strict=True):
        np.testing.assert_array_equal(found, np.cumsum(first, axis=0) + second)


def test_short_parts_are_not_drawn_out_to_the_longest():
    """A long recording beside many pieces costs its own rows, not those of each piece too."""
    together = []

    def follow(numbers, rows):
        together.append((sorted(numbers), len(rows[0])))
        return rows[0]

    lock_step([(np.zeros((count, 1)),) for count in (10, 1000, 12, 6, 600)], follow)
    assert together == [([1, 4], 1000), ([0, 2, 3], 12)]
