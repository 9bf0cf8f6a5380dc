"""Efforts cut off at an end of their range are found, and nothing else is taken for such."""

from dataclasses import replace

from core_helpers import block, EFFECTS, exact_model, messages, recording_of
import numpy as np
import pytest

from hand_load_estimator.identification.clipped_effort import clipped_efforts, clipped_rows, MEMORY
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.stream.joint_stream import motion_of

JOINT = 1


def stream(seed=1, **keywords):
    """Return Messages of a run of the four-axis arm."""
    return messages(exact_model('four'), LoadParameters(), 12.0, seed=seed, size=1.2, **keywords)


def with_efforts(states, change):
    """Return Messages with other efforts of JOINT: change(efforts (N,)) -> (N,)."""
    effort = np.array([m.effort for m in states])
    effort[:, JOINT] = change(effort[:, JOINT])
    return [replace(m, effort=row) for m, row in zip(states, effort)]


def at_most(share):
    """Return a change that cuts efforts off so that `share` of them is."""
    def change(effort):
        most = np.quantile(np.abs(effort), 1.0 - share)
        return np.clip(effort, -most, most)
    return change


def evidence_of(states):
    robot = exact_model('four').robot
    recording = recording_of(states, states[0].names)
    motion, rejected = motion_of(robot, recording)
    return prepare(robot, 'run', motion, LoadParameters(), recording, rejected)


def clipped(states):
    robot = exact_model('four').robot
    recording = recording_of(states, states[0].names)
    motion, _ = motion_of(robot, recording)
    return clipped_rows(robot, motion, recording), motion


@pytest.mark.parametrize('share', [0.05, 0.2, 0.5])
def test_rows_that_hold_what_was_cut_off_are_found(share):
    states = with_efforts(stream(), at_most(share))
    effort, stamp = (np.array([getattr(m, name) for m in states]) for name in ('effort', 'stamp'))
    size = np.abs(effort[:, JOINT])
    at_end = stamp[size >= 0.998 * size.max()]
    rows, motion = clipped(states)
    since = np.array([np.min(t - at_end[at_end <= t], initial=np.inf) for t in motion.stamp])
    assert rows[since < MEMORY - 0.005, JOINT].all()
    assert not rows[since > MEMORY + 0.005, JOINT].any()
    assert not np.delete(rows, JOINT, axis=1).any()


def test_names_in_another_order_are_found():
    states = with_efforts(stream(), at_most(0.2))
    order = [3, 1, 0, 2]
    mixed = [replace(m, names=tuple(np.array(m.names)[order]), **{
        name: np.asarray(getattr(m, name))[order] for name in ('position', 'velocity', 'effort')})
        for m in states]
    expected, _ = clipped(states)
    np.testing.assert_array_equal(clipped(mixed)[0], expected)
    assert expected[:, JOINT].any()


@pytest.mark.parametrize('change', [
    lambda effort: effort, np.zeros_like,
    lambda effort: np.round(effort / 2.0) * 2.0,
    lambda effort: np.full_like(effort, 3.0), lambda effort: effort + np.ptp(effort),
    lambda effort: np.where(np.arange(len(effort)) == 700, 40.0 * effort.max(), effort),
    lambda effort: np.where(np.arange(len(effort)) // 10 == 70, 1.2 * effort.max(), effort)],
    ids=['as it is', 'dead', 'coarse', 'constant', 'an offset', 'one spike', 'a blip'])
def test_nothing_else_is_an_end(change):
    rows, _ = clipped(with_efforts(stream(), change))
    assert not rows.any()


def test_joints_of_a_gripper_beside_do_no_harm():
    states = with_efforts(stream(), at_most(0.2))
    more = [replace(m, names=('gripper', *m.names), **{
        name: np.append(k, getattr(m, name)) for name in ('position', 'velocity', 'effort')})
        for k, m in enumerate(states)]
    np.testing.assert_array_equal(clipped(more)[0], clipped(states)[0])


def test_a_clock_that_starts_anew_mixes_no_passes():
    """What is clipped in one pass has the stamps of another that is not."""
    bad, good = with_efforts(stream(1), at_most(0.2)), stream(2)
    top, largest = (np.abs([m.effort[JOINT] for m in run]).max() for run in (bad, good))
    good = with_efforts(good, lambda effort: 0.9 * top / largest * effort)
    alone, _ = clipped(bad)
    rows, motion = clipped([*bad, *good])
    second = np.flatnonzero(np.diff(motion.stamp) < 0.0)[0] + 1
    np.testing.assert_array_equal(rows[:second], alone)
    assert alone.any() and not rows[second:].any()


def test_a_spike_that_the_guard_rejects_hides_no_end():
    states = with_efforts(stream(), at_most(0.2))
    spoiled = [replace(m, effort=1e5 * np.ones(4)) if k == 700 else m
               for k, m in enumerate(states)]
    assert clipped(spoiled)[0][:, JOINT].mean() > 0.2


def test_identification_does_without_them():
    """They would tell of lighter links."""
    robot = exact_model('four').robot
    whole = [evidence_of(stream(seed)) for seed in (1, 2, 3)]
    cut = [evidence_of(with_efforts(stream(seed), at_most(0.2))) for seed in (1, 2, 3)]
    left_in = [replace(e, clipped=None) for e in cut]
    motion = whole[0].motion.part(slice(0, 400, 10))

    def torque(evidence):
        found = identify(robot, evidence, ('link_inertia', *EFFECTS))
        return np.array([found.torque(*row)[JOINT] for row in
                         zip(motion.q, motion.v, motion.a, motion.temperature)])
    without, with_all = (np.std(torque(e) - torque(whole)) for e in (cut, left_in))
    assert with_all > 5.0 * without
    assert clipped_efforts(robot, whole) == []
    said = clipped_efforts(robot, cut)
    assert len(said) == 3 and 'j1' in said[0] and '%' in said[0]


def test_a_part_keeps_its_rows():
    evidence = evidence_of(with_efforts(stream(), at_most(0.2)))
    rows = slice(100, 300)
    np.testing.assert_array_equal(evidence.part(rows).clipped, evidence.clipped[rows])
    assert evidence.part(rows).tells.shape == evidence.part(rows).torque.shape


def test_a_load_held_makes_no_end():
    states = messages(exact_model('four'), block(2.0), 12.0, seed=2, size=1.2, rest=2.0)
    assert not clipped(states)[0].any()
