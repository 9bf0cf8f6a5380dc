"""The motion filter: one filter for motion and torque, exact derivatives, outputs in time."""

from core_helpers import block, exact_model, messages
import numpy as np
import pytest

from hand_load_estimator.motion import (BANDWIDTH, BLOCK, filter_step, LONGEST_GAP, Motion,
                                        MotionFilter)

DELAY = 3.0 / BANDWIDTH


def run(q, v, effort, stamps, n=1):
    """Return the samples of functions of time (or None for no velocity)."""
    motion_filter, out = MotionFilter(n), []
    for t in stamps:
        columns = [np.full(n, np.nan) if f is None else np.full(n, f(t)) for f in (q, v, effort)]
        sample = motion_filter.update(t, *columns)
        if sample is not None:
            out.append(sample)
    return out


def columns(samples):
    return (np.array([s.stamp for s in samples]),
            *(np.array([getattr(s, name)[0] for s in samples]) for name in
              ('q', 'v', 'a', 'effort')))


def test_filter_step_is_the_exact_response_to_a_ramp():
    """Three equal lags of a ramp t: t - 3/w + transient, known in closed form."""
    dt, w = 0.008, BANDWIDTH
    matrix, before, now = filter_step(dt)
    state, out = np.zeros(3), []
    for k in range(1, 60):
        state = matrix @ state + before * (k - 1) * dt + now * k * dt
        out.append(state[2])
    t = dt * np.arange(1, 60)
    x = w * t
    exact = t - 3.0 / w + np.exp(-x) * (3.0 / w + 2.0 * t + w * t ** 2 / 2.0)
    np.testing.assert_allclose(out, exact, atol=1e-13)


@pytest.mark.parametrize('dt', [1e-4, 1e-3, 0.01, 0.04, 0.25])
def test_two_half_steps_make_one_step(dt):
    whole, half = filter_step(dt), filter_step(dt / 2)
    np.testing.assert_allclose(half[0] @ half[0], whole[0], atol=1e-12)


@pytest.mark.parametrize('with_velocity', [True, False])
@pytest.mark.parametrize('rate', [100.0, 125.0, 500.0, 1000.0])
def test_motion_of_constant_acceleration_is_exact_behind_a_known_delay(rate, with_velocity):
    a = 0.8
    stamps = np.arange(int(2.0 * rate)) / rate
    samples = run(lambda t: 0.5 * a * t * t, (lambda t: a * t) if with_velocity else None,
                  lambda t: 5.0 * t, stamps)
    t, q, v, acc, effort = (c[-20:] for c in columns(samples))
    np.testing.assert_allclose(effort, 5.0 * (t - DELAY), atol=1e-9)
    # Positions between messages are taken as straight lines: an error of a dt^2 / 12.
    straight = a / (12.0 * rate ** 2)
    np.testing.assert_allclose(v, a * (t - DELAY), atol=1e-9 if with_velocity else 1e-4)
    np.testing.assert_allclose(acc, a, atol=1e-9 if with_velocity else 2e-2)
    exact_q = 0.5 * a * ((t - DELAY) ** 2 + 3.0 / BANDWIDTH ** 2)
    np.testing.assert_allclose(q - exact_q, straight, atol=0.1 * straight)


@pytest.mark.parametrize('with_velocity', [True, False])
def test_a_sine_comes_out_with_the_filters_gain_and_delay(with_velocity):
    rate, w = 500.0, 2.0 * np.pi * 0.8
    response = (BANDWIDTH / (BANDWIDTH + 1j * w)) ** 3
    stamps = np.arange(int(3.0 * rate)) / rate
    samples = run(lambda t: np.sin(w * t), (lambda t: w * np.cos(w * t)) if with_velocity
                  else None, lambda t: 7.0 * np.sin(w * t), stamps)
    t, q, v, a, effort = (c[-60:] for c in columns(samples))
    wave = response * np.exp(1j * w * t)
    np.testing.assert_allclose(q, wave.imag, atol=2e-5)
    np.testing.assert_allclose(v, (1j * w * wave).imag, atol=2e-4)
    np.testing.assert_allclose(a, (-w * w * wave).imag, atol=2e-3)
    np.testing.assert_allclose(effort, 7.0 * wave.imag, atol=2e-4)
    delay = -np.angle(response) / w
    assert delay == pytest.approx(DELAY, rel=0.01)


def test_the_acceleration_is_the_derivative_of_the_velocity_that_is_given_out():
    rate = 1000.0
    speed = np.random.default_rng(1).normal(size=2000)
    path = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) / rate))
    motion_filter, v, a = MotionFilter(1), [], []
    motion_filter.update(0.0, path[:1], speed[:1], np.zeros(1))
    for k in range(1, 2000):
        motion_filter.update(k / rate, path[k:k + 1], speed[k:k + 1], np.zeros(1))
        sample = motion_filter._sample(k / rate)
        v.append(sample.v[0])
        a.append(sample.a[0])
    # Simpson's rule over two steps integrates the derivative to third order.
    v, a = np.array(v[199:]), np.array(a[199:])
    area = (a[:-2:2] + 4.0 * a[1:-1:2] + a[2::2]) / (3.0 * rate)
    assert np.std(v[2::2] - v[:-2:2] - area) < 0.01 * np.std(v[2::2] - v[:-2:2])


def test_torque_and_regressor_agree_along_a_motion():
    """F[tau] = F[K] m up to second order: within a hundredth of what the load does."""
    model, load = exact_model('ur10e', (), rate=500.0), block(8.0)
    stream = messages(model, load, 4.0, rate=500.0, noisy=False)
    motion_filter = MotionFilter(6)
    samples = [motion_filter.update(m.stamp, m.position, m.velocity, m.effort) for m in stream]
    samples = [s for s in samples if s is not None and not s.fresh]
    robot, products = model.robot, load.to_products()
    part = np.array([robot.load_regressor(s.q, s.v, s.a) @ products for s in samples])
    rest = np.array([s.effort - robot.rigid_torque(s.q, s.v, s.a) for s in samples])
    size = np.sqrt(np.mean(part ** 2, axis=0))
    assert (np.sqrt(np.mean((rest - part) ** 2, axis=0)) < 0.01 * size.max()).all()
    # Without the filter on the torque it would be off by its delay, several times as much.
    late = np.interp(np.array([s.stamp for s in samples]), [m.stamp for m in stream],
                     [m.effort[1] for m in stream])
    unfiltered = late - np.array([robot.rigid_torque(s.q, s.v, s.a)[1] for s in samples])
    assert np.std(unfiltered - part[:, 1]) > 3.0 * np.std(rest[:, 1] - part[:, 1])


@pytest.mark.parametrize('rate', [94.0, 100.0, 125.0, 250.0, 500.0, 1000.0])
def test_outputs_come_within_twenty_milliseconds(rate):
    samples = run(np.sin, np.cos, np.sin, np.arange(int(2.0 * rate)) / rate)
    dt = np.array([s.dt for s in samples])
    assert dt.max() <= BLOCK * 1.001
    assert np.median(dt) > 0.5 * BLOCK, 'more often than needed costs computing time'
    np.testing.assert_allclose(np.diff([s.stamp for s in samples]), dt[1:], atol=1e-9)


def test_a_jittery_94_hertz_stays_below_the_block_and_its_messages():
    rng = np.random.default_rng(2)
    stamps = np.cumsum(rng.choice([0.010, 0.011, 0.012, 0.002], 400, p=[0.6, 0.2, 0.15, 0.05]))
    dt = np.array([s.dt for s in run(np.sin, np.cos, np.sin, stamps)])
    assert dt.max() <= 0.0221


@pytest.mark.parametrize('rate', [30.0, 40.0])
def test_slow_messages_are_followed_one_by_one(rate):
    stamps = np.arange(int(4.0 * rate)) / rate
    samples = run(np.sin, np.cos, np.sin, stamps)
    assert len(samples) >= len(stamps) - 2
    t, _, v, _, _ = (c[-30:] for c in columns(samples))
    np.testing.assert_allclose(v, np.cos(t - DELAY), atol=2e-3)


def test_a_long_silence_restarts_as_if_nothing_had_been_before():
    rate = 100.0
    motion_filter = MotionFilter(1)
    for k in range(100):
        motion_filter.update(k / rate, np.ones(1), np.ones(1), np.ones(1))
    begin = 1.0 + LONGEST_GAP + 0.01
    samples = [motion_filter.update(begin + k / rate, np.full(1, 5.0), np.zeros(1),
                                    np.full(1, 7.0)) for k in range(50)]
    assert motion_filter.gaps == 1
    samples = [s for s in samples if s is not None]
    assert [s.q[0] for s in samples] == pytest.approx([5.0] * len(samples))
    assert all(s.a[0] == pytest.approx(0.0, abs=1e-9) for s in samples)
    assert samples[0].fresh and not samples[-1].fresh and samples[0].dt <= BLOCK * 1.001


def test_a_short_silence_does_not_restart():
    stamps = np.concatenate([np.arange(0, 1, 0.01), np.arange(1.2, 2, 0.01)])
    samples = run(np.sin, np.cos, np.sin, stamps)
    assert not any(s.fresh for s in samples if s.stamp > 0.2)


def test_a_start_in_motion_is_fresh_until_it_no_longer_shows():
    samples = run(lambda t: 2.0 * t, lambda t: 2.0, lambda t: 3.0, np.arange(200) / 500.0)
    t, _, v, a, _ = columns([s for s in samples if not s.fresh])
    assert len(t) and t[0] < 0.15
    samples = run(lambda t: t, None, lambda t: 3.0, np.arange(200) / 500.0)
    # Without velocities the start in motion shows; what is left of 1 rad/s is below 1 %.
    first = next(s for s in samples if not s.fresh)
    assert first.v[0] == pytest.approx(1.0, abs=0.01)
    assert abs(first.a[0]) < 0.3


def test_velocity_that_comes_and_goes_restarts_rather_than_jumps():
    motion_filter, out = MotionFilter(1), []
    for k in range(300):
        t = k / 100.0
        v = np.array([np.nan if 100 <= k < 200 else 0.5])
        out.append(motion_filter.update(t, np.array([0.5 * t]), v, np.ones(1)))
    steady = [s for s in out if s is not None and not s.fresh]
    assert max(abs(s.v[0] - 0.5) for s in steady) < 0.01
    assert max(abs(s.a[0]) for s in steady) < 0.3
    assert any(1.2 < s.stamp < 2.0 for s in steady)


def test_temperatures_are_held_and_unknown_before():
    motion_filter = MotionFilter(2)
    motion_filter.temperature[1] = 33.0
    motion_filter.restart()
    np.testing.assert_array_equal(motion_filter.temperature, [np.nan, 33.0])


def test_stacked_motion_leaves_out_the_start():
    samples = run(np.sin, np.cos, np.sin, np.arange(100) / 100.0)
    motion = Motion.of(samples)
    assert len(motion.stamp) == sum(not s.fresh for s in samples) < len(samples)
    assert motion.q.shape == (len(motion.stamp), 1)
