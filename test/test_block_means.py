"""Means over blocks of rows: by weight, and none that is part of two recordings."""

import numpy as np

from hand_load_estimator.identification.block_means import all_blocks, Blocks, FEWEST, LENGTHS


def test_means_are_by_the_weights_of_each_joint():
    weights = np.array([[1.0, 0.0], [3.0, 2.0], [0.0, 0.0], [0.0, 5.0]])
    blocks = Blocks(weights, np.zeros(4), 2, 0.1)
    assert blocks.length == 0.2
    values = np.array([[4.0, 9.0], [8.0, 1.0], [7.0, 7.0], [7.0, 6.0]])
    np.testing.assert_allclose(blocks.means(values), [[7.0, 1.0], [0.0, 6.0]])
    np.testing.assert_allclose(blocks.means_for(0, values), [[7.0, 3.0], [0.0, 0.0]])
    np.testing.assert_array_equal(blocks.first(np.arange(4)), [0, 2])
    np.testing.assert_allclose(blocks.average(np.array([[2.0, 3.0], [50.0, 10.0]])),
                               [2.0, (2 * 3.0 + 5 * 10.0) / 7])
    np.testing.assert_allclose(
        blocks.average(np.array([[2.0, 3.0], [50.0, 10.0]]), np.array([[1.0, 0.0], [1.0, 1.0]])),
        [2.0, 10.0])


def test_a_block_in_two_recordings_counts_for_nothing():
    blocks = Blocks(np.ones((6, 1)), np.array([0, 0, 0, 1, 1, 1]), 2, 0.1)
    np.testing.assert_allclose(blocks.average(np.array([[1.0], [100.0], [3.0]])), [2.0])


def test_lengths_of_which_there_are_few_blocks_tell_nothing():
    def lengths(rows):
        return [b.length for b in all_blocks(np.ones((rows, 1)), np.zeros(rows),
                                             np.full(rows, 0.02))]
    np.testing.assert_allclose(lengths(50 * FEWEST), LENGTHS)
    np.testing.assert_allclose(lengths(50 * FEWEST - 1), LENGTHS[:-1])
    assert not lengths(3 * FEWEST - 1)
