"""What is not known of friction as a joint begins, as the motion filter shows it."""

from core_helpers import presliding_path
import numpy as np
import pytest

from hand_load_estimator.course import STEPS
from hand_load_estimator.torque.start_doubt import (rests_along, start_doubt_along,
                                                    StartDoubt)

S, DT = np.array([1e-3, 4e-3]), 0.02


def motion(seed=0):
    """Return ways (N, STEPS, 2), q, v (N, 2) and dt (N,): rest, motion, rest, motion."""
    rng, speed = np.random.default_rng(seed), np.repeat([0.0, 0.1, 0.0, 0.05], 50)
    v = speed[:, None] * rng.choice([-1.0, 1.0], (200, 1)) * np.ones(2)
    moved = np.repeat(v[:, None] * DT / STEPS, STEPS, axis=1)
    return moved, moved.sum(axis=1).cumsum(axis=0), v, np.full(200, DT)


def along(moved, q, v, dt):
    """Return the doubt (N, 2) along a motion."""
    return start_doubt_along(moved, rests_along(q, v, dt), dt, S)


def test_online_is_as_offline():
    rows = motion()
    state = StartDoubt(S)
    online = np.array([state.update(*row) for row in zip(*rows)])
    np.testing.assert_allclose(online, along(*rows), atol=1e-12)
    state.restart()
    np.testing.assert_array_equal(state.update(*(column[0] for column in rows)), online[0])


def test_it_passes_the_filter():
    """As the friction does whose start is unknown: late, and as much of it in all."""
    moved, q, v, dt = motion()
    shown = along(moved, q, v, dt)
    _, plain = presliding_path(q, v, dt, S)
    rising = slice(60, 100)
    assert (shown[rising] >= plain[rising] - 1e-12).all()
    assert shown[53, 0] > 10.0 * plain[53, 0], 'two samples after a joint has turned all the way'
    assert shown[99, 1] < 1e-6
    np.testing.assert_allclose(shown[45:50], plain[45:50], rtol=0.1)
    # What a start adds in all is what the filter hands on of it.
    both = slice(50, 100)
    assert shown[both, 1].sum() - plain[both, 1].sum() == pytest.approx(
        0.03 / DT * plain[49, 1], rel=0.2)


@pytest.mark.parametrize('hours', [0.1, 2.0])
def test_a_rest_of_hours_tells_no_more_than_its_first_minute(hours):
    """And is forgotten as quickly once the joint moves."""
    state, step, still = StartDoubt(S), 1.0, np.zeros(2)
    doubts = np.array([state.update(np.zeros((STEPS, 2)), still, still, step)
                       for _ in range(int(3600.0 * hours))])
    rows = len(doubts)
    offline = along(np.zeros((rows, STEPS, 2)), *np.zeros((2, rows, 2)), np.full(rows, step))
    np.testing.assert_allclose(offline[1:], doubts[1:], rtol=1e-6)
    told = step / doubts ** 2
    assert told[60:].sum() < 0.02 * told.sum()
    moved = np.full((STEPS, 2), 0.5 * DT / STEPS)
    after = [state.update(moved, moved.sum(axis=0) * (k + 1), still + 0.5, DT) for k in range(8)]
    assert (after[-1] < 1e-2).all()
