"""Stamps of another clock in one's own time: what has waited in a queue is old."""

import pytest

from hand_load_estimator.nodes.stamps import ClockOffset


def test_what_has_waited_is_as_old_as_it_is():
    offset = ClockOffset()
    for k in range(100):
        assert offset.update(50.0 + 0.01 * k, 1000.0 + 0.01 * k) == pytest.approx(50.0 + 0.01 * k)
    # A hiccup of half a second, and all of it arrives at once.
    for k in range(50):
        here = offset.update(51.5, 1001.0 + 0.01 * k)
        assert here == pytest.approx(51.0 + 0.01 * k)
    assert offset.here(1001.2) == pytest.approx(51.2)


def test_clocks_that_run_apart_are_followed():
    offset = ClockOffset()
    for k in range(60000):
        here = offset.update(0.0100005 * k, 0.01 * k)
    assert here == pytest.approx(0.0100005 * 59999, abs=1e-3)


@pytest.mark.parametrize('jump', [-30.0, 30.0])
def test_a_clock_that_jumps_is_followed_within_seconds(jump):
    offset = ClockOffset()
    for k in range(600):
        now = 0.01 * k + jump * (k >= 300)
        here = offset.update(now, 7.0 + 0.01 * k)
    assert here == pytest.approx(now)


@pytest.mark.parametrize('jump', [-30.0, 0.3, 30.0])
def test_beside_a_clock_that_nobody_sets_a_jump_is_followed_at_once(jump):
    offset = ClockOffset()
    for k in range(600):
        now = 0.01 * k + jump * (k >= 300)
        assert offset.update(now, 7.0 + 0.01 * k, 3.0 + 0.01 * k) == pytest.approx(now)
    # What waits is late on both, and still as old as it is.
    assert offset.update(now + 2.0, 7.0 + 0.01 * k, 3.0 + 0.01 * k + 2.0) == pytest.approx(now)


def test_begun_anew_it_knows_nothing_of_before():
    offset = ClockOffset()
    offset.update(10.0, 10.0)
    offset.restart()
    assert offset.update(20.0, 3.0) == 20.0
