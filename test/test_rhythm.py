"""A residual that rings is told from one that is merely coloured, or moves as the arm does."""

import numpy as np
import pytest
from ringing_helpers import NEEDED, recorded

from hand_load_estimator.residual.measured.rhythm import rhythm, ringing


@pytest.mark.parametrize('memory', [0.05, 0.3, 2.0])
def test_coloured_noise_does_not_ring(memory):
    for seed in range(6):
        noise, speed, dt, owner, _ = recorded(seed, memory)
        found = rhythm(noise, speed, dt, owner)
        assert not found.sure(NEEDED) and found.gain < 15.0


@pytest.mark.parametrize('frequency', [0.85, 1.7, 4.0])
def test_what_swings_rings_with_its_frequency_however_strongly(frequency):
    """Also where it pauses for a recording, and its amplitude grows."""
    noise, speed, dt, owner, time = recorded(1)
    strength = noise.std() * (1.0 + 3.0 * time / time[-1]) * (owner != 2)
    swing = strength * np.sin(2.0 * np.pi * frequency * time)
    found = rhythm(noise + swing[:, None], speed, dt, owner)
    assert found.sure(NEEDED)
    assert found.frequency == pytest.approx(frequency, rel=0.05)
    assert found.share.min() > 0.3 and found.own < 0.1


@pytest.mark.parametrize('windows, sure', [((0, 1, 9, 10), True), ((0, 1, 2, 3), False)])
def test_what_more_than_one_recording_sets_off_is_no_burst(windows, sure):
    """Gains of a window that rings and of one that does not differ by more than they are."""
    noise, speed, dt, owner, time = recorded(7)
    strength = 4.0 * noise.std() * np.isin((time / 10.0).astype(int), windows)
    swing = strength * np.sin(2.0 * np.pi * 1.3 * time)
    found = rhythm(noise + swing[:, None], speed, dt, owner)
    assert found.gain > NEEDED and found.sure(NEEDED) == sure
    assert found.gain < 3.0 * found.gain_std


@pytest.mark.parametrize('frequency, order', [(1.2, 1), (0.8, 2)])
def test_the_motion_s_own_rhythm_is_no_discovery(frequency, order):
    """Of one joint that moves, whichever the residual's; or at twice its frequency."""
    noise, speed, dt, owner, time = recorded(2)
    speed[:, 2] += 10.0 * np.sin(2.0 * np.pi * frequency * time)
    made = np.sin(2.0 * np.pi * order * frequency * time)
    found = rhythm(noise[:, :2] + 10.0 * made[:, None], speed, dt, owner)
    assert found.gain > NEEDED and not found.sure(NEEDED)
    assert rhythm(noise[:, :2] + 10.0 * made[:, None], speed[:, :2], dt, owner).sure(NEEDED)


def test_one_joint_that_rings_is_no_account_of_the_others():
    noise, speed, dt, owner, time = recorded(3)
    noise[:, 0] += 10.0 * np.sin(2.0 * np.pi * 1.2 * time)
    assert not rhythm(noise, speed, dt, owner).sure(NEEDED)
    assert rhythm(noise[:, :1], speed[:, :1], dt, owner).sure(NEEDED)
    found, columns = ringing(noise, speed, dt, owner, NEEDED)
    assert columns == [0] and found.frequency == pytest.approx(1.2, rel=0.05)


@pytest.mark.parametrize('memory', [0.05, 2.0])
def test_no_joint_of_coloured_noise_is_picked_out(memory):
    for seed in range(6):
        noise, speed, dt, owner, _ = recorded(seed, memory)
        assert ringing(noise, speed, dt, owner, NEEDED / 4.0) is None


def test_short_recordings_and_silence_tell_nothing():
    noise, speed, dt, owner, _ = recorded(4, runs=1)
    assert rhythm(noise[:1000], speed[:1000], dt[:1000], owner[:1000]) is None
    assert rhythm(np.zeros_like(noise), speed, dt, owner) is None
    noise, speed, dt, owner, _ = recorded(4)
    assert rhythm(noise[::25], speed[::25], 25.0 * dt[::25], owner[::25]) is None


def test_a_joint_that_is_silent_for_a_while_hides_nothing():
    noise, speed, dt, owner, time = recorded(5)
    noise += 3.0 * np.sin(2.0 * np.pi * 1.7 * time)[:, None]
    noise[500:1000, 0] = 0.0
    assert rhythm(noise, speed, dt, owner).sure(NEEDED)
