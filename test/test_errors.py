"""Errors reach the user as sentences, also those of worker processes."""

from concurrent.futures import ProcessPoolExecutor

import pytest

from hand_load_estimator.errors import ConfigurationError


def refuse():
    raise ConfigurationError('here', 'is wrong', 3, '1 or 2', 'take 1')


def test_an_error_of_a_worker_process_is_the_same_sentence_here():
    with ProcessPoolExecutor(1) as pool, pytest.raises(ConfigurationError) as found:
        pool.submit(refuse).result()
    assert str(found.value) == "here: is wrong; got 3; allowed: 1 or 2; take 1"
    assert found.value.where == 'here'
