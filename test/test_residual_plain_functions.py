"""Plain functions: hats make any smooth one, and stay finite where all is at rest."""

import numpy as np

from hand_load_estimator.residual.tracing.plain_functions import hats


def test_hats_make_any_smooth_function():
    values = np.random.default_rng(0).normal(size=2000)
    columns = hats(values, 32)
    inside = np.abs(values) < 2.0
    np.testing.assert_allclose(columns.sum(axis=1), 1.0)
    target = np.tanh(3.0 * values)
    fit, *_ = np.linalg.lstsq(columns, target, rcond=None)
    assert np.abs(columns @ fit - target)[inside].max() < 0.03
    assert hats(np.zeros(100), 32).shape == (100, 0)


def test_plain_functions_of_what_has_come_to_rest_are_finite():
    """A filter forgets down to 1e-300, and no knots are that near to each other."""
    resting = np.concatenate([10.0 ** -np.linspace(3.0, 307.0, 400), -np.ones(200) * 1e-5])
    with np.errstate(all='raise', under='ignore'):
        columns = hats(resting, 16)
    assert np.isfinite(columns).all() and np.abs(columns).max(initial=0.0) <= 1.0
    assert not hats(np.zeros(100), 16).shape[1]
