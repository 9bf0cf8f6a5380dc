"""Ripple: waves as the motion filter shows them, and their periods found in noise."""

import numpy as np
import pytest

from hand_load_estimator.effects.torque_ripple import waves
from hand_load_estimator.motion import MotionFilter
from hand_load_estimator.residual.measured.blocks import Blocks
from hand_load_estimator.residual.tracing import ripple
from hand_load_estimator.residual.tracing.ripple import CANDIDATES, likely_periods, NEAR, TURNS


def wave(q, v, periods, phase):
    sine, cosine = waves(q, v, periods)
    return np.cos(phase) * sine + np.sin(phase) * cosine


@pytest.mark.parametrize('periods', [20.0, 60.0, 150.0])
@pytest.mark.parametrize('speed', [0.1, 0.5, 1.0])
def test_a_wave_is_what_comes_through_the_motion_filter(periods, speed):
    motion, phase = MotionFilter(1), 0.7
    found = []
    for k in range(1000):
        q = speed * k * 1e-3
        sample = motion.update(k * 1e-3, np.array([q]), np.array([speed]),
                               np.sin([periods * q + phase]))
        found += [sample] if sample is not None and not sample.fresh else []
    q, v, torque = (np.array([getattr(s, f)[0] for s in found]) for f in ('q', 'v', 'effort'))
    expected = wave(q, v, periods, phase)
    assert len(found) > 30
    np.testing.assert_allclose(torque, expected, atol=0.03 * np.abs(expected).max() + 1e-3)


def waving(periods, size, seed=0, count=4000):
    """Return q, v, residual, weights (N,) of a joint with a ripple in white noise of std 1."""
    rng, t = np.random.default_rng(seed), 0.02 * np.arange(count)
    q = 0.8 * np.sin(0.5 * t) + 0.5 * np.sin(0.23 * t + 1.0)
    v = 0.4 * np.cos(0.5 * t) + 0.115 * np.cos(0.23 * t + 1.0)
    residual = size * wave(q, v, periods, 0.3) + rng.normal(size=count)
    return q, v, residual, np.full(count, 1.0)


@pytest.mark.parametrize('periods', [11.3, 61.7, 152.0, 310.5])
def test_a_period_is_found_in_noise(periods):
    found, tried = likely_periods(*waving(periods, 0.5))
    # All that was looked at counts: the spectrum, and what refined each of its peaks.
    assert len(found) <= CANDIDATES and tried > 100 + len(found) * TURNS * NEAR
    assert found[0] == pytest.approx(periods, abs=0.25)


def test_a_period_found_in_noise_alone_gains_nothing():
    """Some period is always best; on blocks it was not fitted to it gains no more than chance."""
    for seed in range(4):
        q, v, residual, weights = waving(60.0, 0.0, seed)
        blocks = Blocks(residual[:, None], weights[:, None], [np.zeros((len(q), 0))],
                        np.arange(0, len(q), 200), np.arange(len(q) // 200) % 5)
        found, tried = likely_periods(q, v, residual, weights)
        assert len(found) == CANDIDATES
        for periods in found:
            columns = np.stack(waves(q, v, periods), axis=1)
            # The period itself is fitted to all blocks: the best of so many trials.
            assert blocks.evaluate({0: columns}).gain < 3.0 + np.log(tried)
    strong = waving(60.0, 0.5)
    blocks = Blocks(strong[2][:, None], strong[3][:, None], [np.zeros((len(strong[0]), 0))],
                    np.arange(0, 4000, 200), np.arange(20) % 5)
    found = likely_periods(*strong)[0][0]
    columns = np.stack(waves(*strong[:2], found), axis=1)
    assert blocks.evaluate({0: columns}).gain > 100.0


def test_the_spectrum_turned_on_is_that_of_the_waves():
    q, v, residual, weights = waving(61.7, 0.5)
    grid = np.arange(5.0, 399.0, 0.6)
    turned = ripple._spectrum(q, v, residual, weights, grid, 0.6)
    each = [ripple._explained(ripple._wave(q, v, p), v, residual, weights, p) for p in grid]
    np.testing.assert_allclose(turned, each, rtol=1e-9, atol=1e-9 * max(each))


def test_a_joint_that_hardly_moves_has_no_period():
    q, v, residual, weights = waving(60.0, 3.0)
    found, tried = likely_periods(0.01 * q, 0.01 * v, residual, weights)
    assert len(found) == tried == 0
