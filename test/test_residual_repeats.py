"""Motion that recordings repeat is held out together, and where there is no other tells little."""

import numpy as np
import pytest
from residual_helpers import cable, declared_model, Hidden, noise_of, on, recorded

from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.motion import Motion
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, SUSPECTED
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.measured.folds import cut_into_blocks
from hand_load_estimator.residual.measured.repeats import first_shown, share_repeated, share_shown
from hand_load_estimator.torque.columns import torque_columns
from hand_load_estimator.torque.motion_inputs import motion_input

DT, JOINTS = 0.02, 4
REPEATED = 'cannot tell any effect for sure because all recordings repeat one motion of'


def waves(seed, seconds, period=None):
    """Return q, v, a (N, n) of smooth waves; period [s]: that they repeat after."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, DT)[:, None]
    w = 2.0 * np.pi * (np.arange(1, 4) / period if period else rng.uniform(0.1, 0.4, 3))
    q, v, a = (np.zeros((len(t), JOINTS)) for _ in range(3))
    for k in w:
        size, phase = rng.uniform(0.2, 0.6, JOINTS), rng.uniform(0.0, 6.3, JOINTS)
        q += size * np.sin(k * t + phase)
        v += size * k * np.cos(k * t + phase)
        a -= size * k * k * np.sin(k * t + phase)
    return q, v, a


def shown(*parts, spread=3e-3):
    """Return the Shown of motions (q, v, a), each measured with an error of so many radians."""
    rng = np.random.default_rng(0)
    q, v = (np.concatenate([p[k] for p in parts]) for k in range(2))
    owner = np.repeat(np.arange(len(parts)), [len(p[0]) for p in parts])
    return first_shown(q + spread * rng.normal(size=q.shape), v, np.full(len(q), DT),
                       owner), owner


def pieces(*parts):
    """Return (fold, group) of every row, and whether a Cut of motions is by motion."""
    found, owner = shown(*parts)
    cut = cut_into_blocks(np.full(len(owner), DT), owner, owner, found)
    lengths = np.diff(np.append(cut.starts, len(owner)))
    return np.repeat(cut.folds, lengths), np.repeat(cut.groups, lengths), cut


def test_the_same_programme_run_again_was_shown_before():
    once = waves(1, 25.0)
    # Started 2 s later.
    again = tuple(np.concatenate([np.repeat(part[:1], 100, axis=0), part]) for part in once)
    found, owner = shown(once, again)
    rows = len(once[0])
    assert found.fresh[:rows].mean() > 0.95
    later = np.arange(rows + 150, 2 * rows + 50)
    assert not found.fresh[later].any()
    np.testing.assert_allclose(found.first[later], later - rows - 100, atol=6)


def test_a_cycle_was_shown_before_from_its_second_turn_on():
    found, _ = shown(waves(2, 30.0, period=7.0))
    turn = round(7.0 / DT)
    assert found.fresh[:turn].all() and not found.fresh[turn + 20:].any()
    np.testing.assert_allclose(found.first[turn + 20:],
                               np.arange(turn + 20, len(found.first)) % turn, atol=6)


def test_other_motions_were_not_shown():
    found, _ = shown(*(waves(seed, 20.0) for seed in (3, 4, 6, 7)))
    assert found.fresh.all()


def test_the_same_path_the_other_way_or_at_half_speed_is_another_motion():
    q, v, a = waves(10, 20.0)
    assert shown((q, v, a), (q[::-1], -v[::-1], a[::-1]))[0].fresh.all()
    assert shown((q, v, a), (np.repeat(q, 2, axis=0), np.repeat(v, 2, axis=0) / 2.0, a))[0] \
        .fresh.mean() > 0.9


def test_a_joint_that_stands_does_not_hide_a_repetition():
    q, v, a = waves(9, 20.0)
    q[:, 2], v[:, 2] = 0.3, 0.0
    found, _ = shown((q, v, a), (q, v, a), spread=1e-3)
    assert not found.fresh[len(q) + 50:].any()


def test_an_arm_that_stands_repeats_nothing():
    still = np.full((500, JOINTS), 0.2)
    assert shown((still, 0.0 * still), spread=0.0)[0].fresh.all()


def test_an_hour_of_cycles_is_looked_through():
    q, v, a = waves(2, 3600.0, period=7.0)
    found, _ = shown((q[::2], v[::2], a[::2]))
    assert found.fresh.mean() < 0.01


@pytest.mark.parametrize('parts', [
    [waves(1, 25.0)] * 2, [waves(1, 25.0)] * 4, [waves(2, 60.0, period=15.0)],
    [waves(2, 40.0, period=15.0)] * 3])
def test_what_is_held_out_has_no_twin_in_what_is_fitted(parts):
    folds, groups, cut = pieces(*parts)
    found, _ = shown(*parts)
    assert cut.shown is None and 3 <= len(np.unique(folds)) <= 6
    # But for a few rows beside the edges.
    assert (folds == folds[found.first]).mean() > 0.98
    # One group for all repetitions of a piece, which count once.
    assert (groups == groups[found.first]).mean() > 0.97 and groups.max() < 14
    assert set(np.unique(groups)) == set(range(groups.max() + 1))


def test_recordings_of_other_motions_stay_folds_beside_a_repeated_one():
    parts = [waves(seed, 20.0) for seed in (3, 4, 6)]
    folds, _, _ = pieces(*parts, parts[0])
    rows = len(parts[0][0])
    assert [np.bincount(folds[rows * k:rows * k + rows]).argmax() for k in range(4)] \
        == [0, 1, 2, 0]


def test_motions_of_their_own_are_cut_as_ever():
    few, many = [waves(seed, 20.0) for seed in (3, 4)], [waves(s, 20.0) for s in (3, 4, 6)]
    folds, groups, cut = pieces(*few)
    assert len(np.unique(folds)) == 6 and (np.diff(folds) >= 0).all()
    np.testing.assert_array_equal(cut.groups, np.arange(len(cut.starts)))
    np.testing.assert_array_equal(pieces(*many)[0], np.repeat([0, 1, 2], len(many[0][0])))


def test_residuals_of_runs_of_their_own_have_a_fold_each():
    residual = find_residual(declared_model(), recorded())
    assert residual.observations == len(residual.starts)
    assert len(np.unique(residual.folds)) == 4


def of_motion(name, q, v, a, seed):
    """Return the Evidence of an arm with a cable at joint 2 along a motion."""
    model, n = declared_model(), JOINTS
    t, rng = DT * np.arange(len(q)), np.random.default_rng(seed)
    motion = Motion(t, np.full(len(q), DT), q, v, a, np.zeros_like(q), np.full(q.shape, 25.0),
                    np.full(len(q), 10))
    x, _ = motion_input(model.robot, motion, model.presliding_distance(),
                        level=model.contact_level())
    torque = torque_columns(model.robot, model.layout, x) @ model.mean
    torque = torque + on(2, 4.0, cable)(Hidden(model.robot, x, motion, torque))
    return Evidence(name, motion, torque + rng.normal(size=(len(q), n)) * noise_of(model.robot))


def test_one_short_motion_again_and_again_confirms_nothing():
    q, v, a = waves(2, 60.0, period=4.0)
    diagnosis, better = diagnose(declared_model(), [of_motion('cell', q, v, a, 1)])
    assert 'cable_drag' in {f.name for f in diagnosis.findings}
    assert {f.verdict for f in diagnosis.findings} == {SUSPECTED}
    assert any(s.startswith(REPEATED) for s in diagnosis.cannot_tell)
    assert any('what is kept for the test repeats' in s for s in diagnosis.cannot_tell)


def test_a_run_repeated_still_tells_what_its_own_motion_tells():
    once, other = waves(1, 30.0), waves(12, 20.0)
    runs = [of_motion('first', *once, 1), of_motion('second', *once, 2)]
    diagnosis, _ = diagnose(declared_model(), runs, [of_motion('test', *other, 3)])
    assert [(f.name, f.verdict) for f in diagnosis.findings] == [('cable_drag', CONFIRMED)]
    assert diagnosis.findings[0].evidence.blocks < 14
    assert not [s for s in diagnosis.cannot_tell if 'repeat' in s]
    assert share_shown(runs[:1], runs[1:]) > 0.95
    assert share_repeated(runs) == pytest.approx(0.5, abs=0.05) and share_repeated(runs[:1]) < 0.1
    assert share_shown(runs[:1], [of_motion('test', *other, 3)]) < 0.1
