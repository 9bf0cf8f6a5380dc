"""What is left: white noise and that of the acceleration are noise, what lasts is structure."""

from functools import lru_cache

import numpy as np
import pytest

from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.residual.measured.rest import rest_of

JOINTS = 40


@lru_cache(None)
def filtered(rate, seconds):
    """Return the Motion of white noise in all that is measured, behind the motion filter."""
    rng, motion, samples = np.random.default_rng(3), MotionFilter(JOINTS), []
    for t in np.arange(0.0, seconds, 1.0 / rate):
        samples.append(motion.update(t, 0.01 * rng.normal(size=JOINTS),
                                     rng.normal(size=JOINTS), rng.normal(size=JOINTS)))
    return Motion.of([s for s in samples if s is not None])


def rest(motion, residual):
    return rest_of(residual, motion.dt, motion.messages, np.zeros(len(motion.dt), int))


def root(values):
    return np.sqrt(np.mean(np.square(values), axis=0))


@pytest.mark.parametrize('rate', [30, 94, 500])
@pytest.mark.parametrize('source', ['effort', 'a'])
def test_noise_is_noise(rate, source):
    """That of the acceleration differs more from row to row than white noise of its size."""
    motion = filtered(rate, 40.0)
    noise = getattr(motion, source)
    found = rest(motion, noise)
    assert np.mean(found.least_structure > 0.0) < 0.06 and found.least_structure.max() < 0.2
    assert np.mean((found.noise / found.rms) ** 2) > 0.85
    np.testing.assert_allclose(found.most, root(noise), rtol=0.11)


@pytest.mark.parametrize('rate', [30, 94, 500])
def test_structure_that_lasts_is_told_beside_noise(rate):
    motion = filtered(rate, 40.0)
    noise = motion.effort / root(motion.effort)
    slow = np.sin(2.0 * np.pi * 0.9 * motion.stamp + np.arange(JOINTS)[:, None]).T
    found = rest(motion, noise + slow)
    assert np.median(found.least_structure) == pytest.approx(1.0 / 3.0, abs=0.06)
    assert np.median(found.noise) == pytest.approx(1.0, rel=0.1)


def test_noise_does_not_vanish_beside_large_structure():
    """Strokes that begin and end at nothing: pairs of rows within one are larger than rows are."""
    motion = filtered(500, 40.0)
    noise = motion.effort / root(motion.effort)
    stroke = np.where(motion.stamp % 2.0 < 1.0, 30.0 * np.sin(np.pi * motion.stamp), np.nan)
    found = rest(motion, noise + stroke[:, None])
    assert (found.least_structure > 0.9).all()
    assert (found.noise > 0.8).all() and (found.noise <= found.most).all()


def test_an_oscillation_is_structure_at_whatever_lag_it_returns():
    motion = filtered(94, 40.0)
    noise = 0.3 * motion.effort / root(motion.effort)
    found = rest(motion, noise + np.sin(2.0 * np.pi * 4.0 * motion.stamp)[:, None])
    assert (found.least_structure > 0.7).all()


def test_noise_that_was_smoothed_before_is_not_called_either():
    """It is forgotten as noise is, but hardly differs from one row to the next."""
    motion = filtered(500, 40.0)
    smooth = np.stack([np.convolve(column, np.hanning(7), 'same') for column in motion.effort.T],
                      axis=1)
    found = rest(motion, smooth)
    assert np.median(found.least_structure) < 0.2
    assert np.median((found.noise / found.rms) ** 2) < 0.5
    assert (found.noise < 0.8 * found.most).all()


def test_too_little_tells_no_share():
    motion = filtered(30, 1.5)
    assert np.isnan(rest(motion, motion.effort).least_structure).mean() > 0.5


def test_a_joint_that_never_slides_has_no_figures():
    motion = filtered(94, 40.0)
    lost = np.where(np.arange(JOINTS) == 2, np.nan, motion.effort)
    found = rest(motion, lost)
    figures = (found.rms, found.noise, found.most, found.least_structure)
    assert all(np.isnan(f[2]) and np.isfinite(np.delete(f, 2)).all() for f in figures)


def test_recordings_are_not_joined():
    """What lasts over the seam of two recordings is no memory."""
    motion = filtered(94, 40.0)
    alone = rest_of(motion.effort, motion.dt, motion.messages, np.arange(len(motion.dt)))
    assert np.isnan(alone.least_structure).all()
