"""White noise behind the motion filter: its size is found at any rate, spacing and jitter."""

from functools import lru_cache

import numpy as np
import pytest

from hand_load_estimator.motion import Motion, MotionFilter
from hand_load_estimator.torque.filtered_noise import noise_floor, white_density

STD, JOINTS, SECONDS = 1.2, 40, 12.0   # of one reported torque [Nm]
RATES = [30, 75, 94, 125, 500, 1000]   # [Hz]


def filtered(stamps, torque=lambda t: 0.0):
    """Return the Motion of white torque noise of STD reported at stamps (N,) [s]."""
    rng, motion, samples = np.random.default_rng(0), MotionFilter(JOINTS), []
    for t in stamps:
        samples.append(motion.update(t, np.zeros(JOINTS), np.zeros(JOINTS),
                                     torque(t) + STD * rng.normal(size=JOINTS)))
    return Motion.of([s for s in samples if s is not None])


@lru_cache(None)
def reported(rate):
    return filtered(np.arange(0.0, SECONDS, 1.0 / rate))


def size(values):
    """Return the RMS over everything."""
    return np.sqrt(np.mean(np.square(values)))


def found(motion):
    """Return the noise floor [Nm] of a Motion's effort, pooled over joints."""
    return size(noise_floor(motion.effort, motion.dt, motion.messages))


@pytest.mark.parametrize('rate', RATES)
def test_the_floor_of_white_noise_is_its_size(rate):
    """With 20 ms taken for granted it was 0.57 of it at 94 Hz, 0.82 at 125 Hz, 1.05 at 30 Hz."""
    motion = reported(rate)
    assert found(motion) == pytest.approx(size(motion.effort), rel=0.02)


@pytest.mark.parametrize('rate', RATES)
def test_the_density_of_white_noise_is_its_variance_times_the_spacing_of_messages(rate):
    """With 20 ms taken for granted it was 0.31 of it at 94 Hz."""
    motion = reported(rate)
    density = np.mean(white_density(motion.effort, motion.dt, motion.messages))
    assert density == pytest.approx(STD ** 2 / rate, rel=0.04)


@pytest.mark.parametrize('rate', [94, 125])
def test_uneven_stamps_do_no_harm(rate):
    """Messages up to a third of their spacing early or late, and one in ten lost."""
    rng, stamps = np.random.default_rng(1), np.arange(0.0, SECONDS, 1.0 / rate)
    stamps = stamps + rng.uniform(-0.33, 0.33, len(stamps)) / rate
    motion = filtered(stamps[rng.random(len(stamps)) > 0.1])
    assert motion.dt.std() > 2e-3
    assert found(motion) == pytest.approx(size(motion.effort), rel=0.05)


def test_messages_that_nearly_coincide_do_no_harm():
    """A driver may stamp two messages 0.3 ms apart: no step is expected between such rows."""
    stamps = np.arange(0.0, SECONDS, 1.0 / 30)
    stamps[5::10] = stamps[4::10][:len(stamps[5::10])] + 3e-4
    motion = filtered(stamps)
    assert motion.dt.min() < 1e-3
    assert found(motion) == pytest.approx(size(motion.effort), rel=0.1)


def test_rows_of_two_rates_are_judged_together():
    first, second = reported(30), reported(500)
    joined = (np.concatenate([getattr(first, name), getattr(second, name)])
              for name in ('effort', 'dt', 'messages'))
    assert size(second.effort) < size(noise_floor(*joined)) < size(first.effort)


@pytest.mark.parametrize('rate', [30, 94, 500])
def test_structure_is_hardly_noise(rate):
    stamps = np.arange(0.0, SECONDS, 1.0 / rate)
    motion = filtered(stamps, lambda t: STD * np.sin(2.0 * np.pi * 0.7 * t))
    assert found(motion) == pytest.approx(found(reported(rate)), rel=0.08)


def test_rows_left_out_leave_the_floor():
    motion = reported(94)
    effort = motion.effort.copy()
    effort[np.random.default_rng(2).random(effort.shape) < 0.3] = np.nan
    effort[:, 0] = np.nan
    floor = noise_floor(effort, motion.dt, motion.messages)
    assert floor[0] == 0.0
    assert size(floor[1:]) == pytest.approx(size(motion.effort), rel=0.04)
