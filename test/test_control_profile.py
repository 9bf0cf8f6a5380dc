"""Speed profile along a path: limits, ends, restarts from the middle."""

from dataclasses import replace

import numpy as np
import pytest

from hand_load_estimator.control.planned_move import PlannedMove
from hand_load_estimator.control.profile import PathLimits, make_profile

LIMITS = PathLimits(speed=1.5, acceleration=6.0, deceleration=3.0, jerk=60.0)


def sampled(profile):
    t = np.linspace(0.0, profile.duration, 4001)
    return t, *profile.sample(t)


@pytest.mark.parametrize('limits', [
    LIMITS, replace(LIMITS, speed=50.0), replace(LIMITS, speed=0.05),
    replace(LIMITS, acceleration=0.5), replace(LIMITS, deceleration=100.0)])
def test_limits_are_kept_and_the_end_is_at_rest(limits):
    profile = make_profile(limits)
    t, s, v, a = sampled(profile)
    assert v.max() <= limits.speed * (1.0 + 1e-9) and v.min() >= -1e-9
    assert a.max() <= limits.acceleration * (1.0 + 1e-9)
    assert a.min() >= -limits.deceleration * (1.0 + 1e-9)
    assert np.all(np.diff(s) >= -1e-9)
    assert s[-1] == pytest.approx(1.0, abs=1e-9) and v[-1] == pytest.approx(0.0, abs=1e-9)
    assert (profile.s[-1], profile.v[-1], profile.a[-1]) == (1.0, 0.0, 0.0)
    np.testing.assert_allclose(np.gradient(s, t)[5:-5], v[5:-5], atol=2e-2 * limits.speed)
    assert np.sum(v[:-1] * np.diff(t)) == pytest.approx(1.0, abs=2e-3)


def test_stronger_limits_are_never_slower():
    base = make_profile(LIMITS).duration
    for name in ('speed', 'acceleration', 'deceleration'):
        assert make_profile(replace(LIMITS, **{name: 1.3 * getattr(LIMITS, name)})).duration < base


@pytest.mark.parametrize('t', [0.03, 0.15, 0.28, 0.5])
def test_same_limits_from_the_middle_take_the_time_that_was_left(t):
    whole = make_profile(LIMITS)
    state = tuple(float(x[0]) for x in whole.sample(np.array([t])))
    rest = make_profile(LIMITS, state)
    assert t + rest.duration == pytest.approx(whole.duration, abs=1e-6)
    s, v, a = rest.sample(np.array([0.0]))
    np.testing.assert_allclose([s[0], v[0], a[0]], state, atol=1e-12)


def test_a_tightened_limit_fades_the_acceleration_under_way():
    rest = make_profile(replace(LIMITS, acceleration=1.0), (0.02, 0.3, 6.0))
    assert rest.a[0] == 6.0 and rest.a[1] == pytest.approx(1.0)
    _, v, a = rest.sample(np.linspace(0.0, rest.duration, 1000))
    assert np.all(np.diff(a) <= 1e-9 + 60.0 * rest.duration / 999) and v.max() <= 1.5 + 1e-9
    assert rest.v[-1] == 0.0 and rest.s[-1] == 1.0


def test_too_late_to_stop_says_so():
    assert make_profile(LIMITS, (0.95, 1.5, 0.0)) is None
    assert make_profile(replace(LIMITS, deceleration=60.0, jerk=1e4), (0.95, 1.5, 0.0)) \
        is not None


def test_the_knots_sent_are_the_move_planned():
    profile = make_profile(LIMITS)
    move = PlannedMove(np.array([0.1, 2.0]), np.array([1.3, -1.0]), profile, LIMITS, LIMITS, '')
    t = np.linspace(0.0, move.duration, 777)
    for knots, planned in zip(move.trajectory().sample(t), move.points(t)):
        np.testing.assert_allclose(knots, planned, atol=1e-9)
    assert not move.trajectory().velocity[-1].any(), 'rest, without rounding'
    assert not move.trajectory().acceleration[-1].any()
