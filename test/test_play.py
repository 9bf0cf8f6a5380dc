"""Play: the motor is spared a torque and gets it back with the impact."""

import numpy as np
import pytest

from hand_load_estimator.torque.play import crossing_inertia, FILTER_DELAY, PlayAlong, PlayState

DT, INERTIA = 0.02, 4.0
FINE = 0.004  # [s] sums over samples are integrals there
AT_ONCE = 1e-6  # [s]
# Of two joints, and gaps that they might have.
USUAL, JOINTS = [1.4, 1.6], np.array([1, 0, 1])
GAPS = [np.array(values) for values in (
    [0.01, 0.02, 0.03], [0.0, 0.01, 0.02], [1.0, 0.5, 0.1], [1e-6, 0.005, 0.02])]


def random_recording(count, seed):
    """Return torque, inertia (N, 2) and dt (N,) of a recording."""
    rng = np.random.default_rng(seed)
    torque, dt = np.cumsum(rng.normal(size=(count, 2)), axis=0), rng.uniform(0.01, 0.03, count)
    return torque, rng.uniform(1.0, 2.0, (count, 2)), dt


def added(torque, travel, dt=DT, lag=0.0, inertia=INERTIA, impact=AT_ONCE):
    """Return the torque (N,) [Nm] that play adds along torque (N,) [Nm]."""
    column, steps = np.asarray(torque, dtype=float)[:, None], np.full(len(torque), dt)
    along = PlayAlong(((column, np.full_like(column, inertia), steps),), [inertia])
    return along(0, travel, lag, 1.0, impact)


def test_a_gear_loaded_to_one_side_shows_no_play():
    t = np.arange(0.0, 6.0, DT)
    assert not added(20.0 + 15.0 * np.sin(5.0 * t), 0.01).any()
    assert not added(-20.0 + 15.0 * np.sin(5.0 * t), 0.01).any()


def test_a_crossing_gives_back_what_it_spared():
    """The link's momentum at the impact is all the torque that the drive did not carry."""
    torque = 30.0 * np.clip(np.arange(-1.0, 2.0, FINE), -0.5, 0.5)
    felt = added(torque, 0.01, FINE)
    assert felt.min() < -1.0 and felt.max() > 3.0
    assert abs(felt.sum()) < 0.002 * np.abs(felt).sum()


@pytest.mark.parametrize('travel', [0.002, 0.02])
@pytest.mark.parametrize('slope', [15.0, -60.0])
def test_the_link_flies_through_the_gap_by_itself(travel, slope):
    """Under a torque that grows with time, travel = slope t^3 / (6 inertia)."""
    t = np.arange(-1.0, 2.0, FINE)
    felt = added(slope * t, travel, FINE) * np.sign(slope)
    flight = (6.0 * INERTIA * travel / abs(slope)) ** (1.0 / 3.0)
    # The impact returns at one moment what was spared in the mean at two thirds of the flight:
    # the first moment of the two is impulse x flight / 3.
    impulse = 0.5 * abs(slope) * flight ** 2
    assert (t @ felt) * FINE == pytest.approx(impulse * flight / 3.0, rel=0.05)


def test_the_filter_does_not_make_it_later():
    """Torque and effort pass one filter: its delay shows once, not twice."""
    slope, travel = 40.0, 0.01
    torque = slope * (np.arange(0.0, 3.0, DT) - 1.0 - FILTER_DELAY)
    felt, t = added(torque, travel), np.arange(0.0, 3.0, DT)
    flight = (6.0 * INERTIA * travel / slope) ** (1.0 / 3.0)
    # A spike filtered by three stages of time constant T peaks 2 T after it.
    assert t[np.argmax(felt)] == pytest.approx(1.0 + flight + 2.0 * FILTER_DELAY / 3.0, abs=DT)


def test_teeth_that_lag_part_late():
    torque, lag = 40.0 * (np.arange(0.0, 3.0, FINE) - 1.0), 5 * FINE
    prompt, late = (added(torque, 0.01, FINE, by) for by in (0.0, lag))
    np.testing.assert_allclose(late[5:], prompt[:-5], atol=0.02 * prompt.max())


def test_an_impact_takes_its_time():
    """The same momentum, later in the mean by the time that the teeth need to take it."""
    torque, t = 30.0 * np.clip(np.arange(-1.0, 2.0, FINE), -0.5, 0.5), np.arange(-1.0, 2.0, FINE)
    hard, soft = (added(torque, 0.01, FINE, impact=impact) for impact in (AT_ONCE, 0.03))
    assert soft.max() < 0.7 * hard.max()
    assert soft.sum() == pytest.approx(hard.sum(), abs=0.01 * np.abs(hard).sum())
    # Under 30 Nm/s the gap is crossed in (6 x inertia x travel / 30)^(1/3) s.
    struck = 0.5 * 30.0 * (6.0 * INERTIA * 0.01 / 30.0) ** (2.0 / 3.0)
    assert t @ (soft - hard) * FINE == pytest.approx(0.03 * struck, rel=0.05)


@pytest.mark.parametrize('lag', [0.01, 0.02, 0.04])
def test_the_teeth_part_when_their_own_torque_turns(lag):
    """... also where it does so on a curve: all of the filter comes off, and the lag on."""
    dt, stage, curve = 1e-4, FILTER_DELAY / 3.0, 6000.0
    t = np.arange(-0.2, 0.2, dt)
    of = {late: 0.5 * curve * t ** 2 - 12.0 - late * curve * t for late in (lag, FILTER_DELAY)}
    shown = of[FILTER_DELAY] + 6.0 * stage ** 2 * curve
    parts = np.flatnonzero(of[lag] + lag ** 2 * curve < 0.0)[0]
    felt = added(shown, 10.0, dt, lag)
    assert np.flatnonzero(felt)[0] == pytest.approx(parts, abs=10)


def test_play_is_followed_sample_by_sample():
    """... and gaps that a joint might have beside one another are each what they are alone."""
    recording = random_recording(200, seed=0)
    whole = PlayAlong((recording,), USUAL)(JOINTS, *GAPS)
    states = [PlayState(), PlayState()]
    parts = [PlayAlong((tuple(rows[k:k + 1] for rows in recording),), USUAL, states)(JOINTS, *GAPS)
             for k in range(200)]
    assert whole.shape == (200, 3) and np.abs(whole).max() > 0.1
    np.testing.assert_allclose(np.concatenate(parts), whole)
    for column, joint, *gap in zip(whole.T, JOINTS, *GAPS):
        alone = PlayAlong((recording,), USUAL)(joint, *gap)
        np.testing.assert_allclose(column, alone, atol=1e-12)


def test_recordings_are_each_what_they_are_alone():
    """... whatever their lengths and the times between their samples."""
    several = [random_recording(count, seed) for seed, count in enumerate((200, 50, 120))]
    alone = [PlayAlong((recording,), USUAL)(JOINTS, *GAPS) for recording in several]
    np.testing.assert_allclose(PlayAlong(tuple(several), USUAL)(JOINTS, *GAPS),
                               np.concatenate(alone), atol=1e-12)


def test_the_pose_shows_as_much_as_told():
    poses = np.array([1.0, 4.0, 16.0])
    np.testing.assert_allclose(crossing_inertia(poses, 4.0, 1.0), poses)
    np.testing.assert_allclose(crossing_inertia(poses, 4.0, 0.0), 4.0)
    np.testing.assert_allclose(crossing_inertia(poses, 4.0, 0.5), [2.0, 4.0, 8.0])


def test_a_link_without_inertia_is_across_at_once():
    """A robot file drafted from a URDF without masses has such links."""
    t = np.arange(-1.0, 2.0, FINE)
    for inertia in (0.0, 1e-12):
        np.testing.assert_allclose(added(30.0 * t, 0.01, FINE, inertia=inertia), 0.0, atol=1e-6)
