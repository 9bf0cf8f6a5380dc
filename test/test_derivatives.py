"""Velocity and acceleration of least noise from position and velocity."""

import numpy as np
import pytest

from hand_load_estimator.derivatives import Derivatives
from hand_load_estimator.motion import BANDWIDTH, MotionFilter

RATE = 500.0
POSITION, VELOCITY = 6e-6, 2e-3


def accelerations(position_noise=POSITION, velocity_noise=VELOCITY, quantum=1e-9, rest=0.0,
                  rate=RATE, jitter=0.0, lost=(), glitch=None):
    """
    Return stamps and errors [rad/s^2] (N,) of twenty seconds of sine, begun after a rest.

    jitter [s] of stamps; lost: spans [s] without messages; glitch: number of a message
    with a false velocity.
    """
    rng, out, motion = np.random.default_rng(3), [], MotionFilter(1)
    # The filter at the sine's 2 rad/s.
    delayed = (BANDWIDTH / (2j + BANDWIDTH)) ** 3
    for k in range(int(20.0 * rate)):
        t = k / rate
        if any(a < t < b for a, b in lost):
            continue
        s = 2.0 * max(t - rest, 0.0)
        q, v = np.array([1.0 - np.cos(s)]), np.array([2.0 * np.sin(s)])
        read = np.round((q + position_noise * rng.standard_normal(1)) / quantum) * quantum
        told = v + velocity_noise * rng.standard_normal(1) + 5.0 * (k == glitch)
        sample = motion.update(t + jitter * rng.standard_normal(), read, told, q)
        if sample is not None and not sample.fresh and t > rest + 0.2:
            out.append((t, sample.a[0] - 4.0 * (delayed * np.exp(1j * s)).real))
    return np.array(out).T


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


# RMS of the acceleration of white noise by Parseval: of a velocity, and of a position.
OF_VELOCITY = VELOCITY * np.sqrt(BANDWIDTH ** 3 / RATE / 16.0)
OF_POSITION = POSITION * np.sqrt(3.0 * BANDWIDTH ** 5 / RATE / 16.0)


def test_a_fine_encoder_beside_a_noisy_velocity_halves_the_noise():
    t, error = accelerations()
    best = 1.0 / np.hypot(1.0 / OF_VELOCITY, 1.0 / OF_POSITION)
    assert best < 0.5 * OF_VELOCITY
    assert rms(error[t > 2.0]) == pytest.approx(best, rel=0.15)


def test_a_coarse_encoder_is_left_out_also_after_a_long_rest():
    t, error = accelerations(0.0, quantum=5e-4, rest=8.0)
    assert rms(error[t > 8.0]) < 1.1 * OF_VELOCITY


@pytest.mark.parametrize('rate', [31.25, 50.0, 62.5])
def test_positions_far_apart_tell_no_acceleration(rate):
    """Straight lines between them would be off by up to 1 rad/s^2 of 4."""
    error = accelerations(rate=rate)[1]
    assert rms(error) < 1.5 * np.sqrt(RATE / rate) * OF_VELOCITY


def test_jittering_stamps_leave_the_velocitys():
    t, error = accelerations(jitter=2e-4)
    assert rms(error[t > 2.0]) < 1.3 * OF_VELOCITY
    # They would spoil the position: 2 rad/s make 0.4 mrad of 0.2 ms.
    assert 4e-4 / POSITION * OF_POSITION > 5.0 * OF_VELOCITY


def test_lost_messages_spoil_neither_what_follows_nor_the_weights():
    lost = [(t, t + 0.04) for t in np.arange(5.0, 19.0, 1.0)]
    t, error = accelerations(lost=lost)
    after = ((t - 5.0) % 1.0 < 0.2) & (t > 5.0)
    assert rms(error[after]) < 3.0 * OF_VELOCITY
    assert rms(error[(t > 5.0) & ~after]) < 0.6 * OF_VELOCITY


def test_one_false_velocity_is_soon_forgotten():
    t, error = accelerations(0.0, quantum=5e-4, glitch=5000)
    assert rms(error[t > 10.5]) < 1.2 * OF_VELOCITY


def test_without_anything_seen_it_is_the_velocitys():
    derivatives = Derivatives(2)
    velocity = np.array([[1.0, 1.0], [3.0, 4.0]])
    np.testing.assert_array_equal(derivatives.update(0.5 * velocity, velocity), velocity)


def test_joints_weigh_by_their_own_noise_and_keep_it_over_a_gap():
    rng, derivatives = np.random.default_rng(0), Derivatives(2)
    fine, coarse, moves = np.array([0.01, 0.1]), np.array([0.1, 0.01]), np.ones(2)
    for k in range(300):
        derivatives.update(np.array([moves, fine * rng.standard_normal(2)]),
                           np.array([moves, coarse * rng.standard_normal(2)]))
    share = derivatives.share.copy()
    assert share[0] > 0.9 and share[1] < 0.1
    derivatives.restart()
    # What lies on both sides of the gap is not taken for noise.
    for _ in range(4):
        derivatives.update(np.array([moves, 1e3 * moves]), np.array([moves, -1e3 * moves]))
    np.testing.assert_array_equal(derivatives.share, share)
