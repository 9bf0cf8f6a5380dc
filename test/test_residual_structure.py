"""Where a residual lives: each variable lights up for what follows it, and nothing for noise."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import (cable, clean_runs, declared_model, Hidden, noise_of, on, recorded,
                              resonance, SECONDS, viscous, warming)

from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.measured.foretelling import Foretelling
from hand_load_estimator.residual.measured.structure import (followed, ORDER, structures,
                                                             TEMPERATURE)
from hand_load_estimator.residual.tracing.plain_functions import hats

JOINT, OTHER = 1, 3
WARMED = (0, 1, 2, 3)


def constant(run):
    return np.ones_like(run.torque)


def direction(run):
    return np.sign(run.x.v)


def acceleration(run):
    return run.x.a


def over_time(run):
    """Friction that grows within every run."""
    return np.linspace(-1.0, 1.0, len(run.torque))[:, None] * np.sign(run.x.v)


def of_another(run):
    return np.sin(run.x.q[:, [OTHER]]) * np.ones_like(run.torque)


def told(evidence, warmed=WARMED, better=None):
    """Return (Structure before, Structure after)."""
    model = declared_model()
    residual = find_residual(model, evidence)
    return structures(model, better or model, residual, evidence, warmed)


@pytest.mark.parametrize('function, variable', [
    (constant, 'constant'), (cable, 'position'), (resonance, 'velocity'),
    (direction, 'direction'), (acceleration, 'acceleration'), (warming, 'temperature'),
    (over_time, 'time')])
def test_what_follows_a_variable_is_seen_at_it(function, variable):
    before, _ = told(recorded(on(JOINT, 4.0, function)))
    share = {name: before.share[name][JOINT] for name in ORDER}
    assert share[variable] > 0.6 and share[variable] > before.chance[variable][JOINT]
    # Velocity tells the direction; others may share a part only.
    more = [name for name in ORDER if share[name] > share[variable] + 0.02]
    assert more == []
    assert before.structured[JOINT] > 0.5
    calm = [j for j in WARMED if j != JOINT]
    assert all((before.share[name][calm] < 0.2).all() for name in ORDER)


def test_what_follows_another_joint_is_seen_at_the_pair():
    before, _ = told(recorded(on(JOINT, 4.0, of_another)))
    row = before.pairs[JOINT]
    assert row[OTHER] > 0.6 and row[OTHER] > before.pairs_chance[JOINT, OTHER]
    assert np.delete(row, OTHER).max() < 0.4
    own, _ = told(recorded(on(JOINT, 4.0, viscous)))
    assert own.pairs[JOINT, JOINT] > 0.6 and np.delete(own.pairs[JOINT], JOINT).max() < 0.2


def test_noise_follows_nothing():
    """Noise with a memory of 0.1 s: of 2 x (32 + 16) cells hardly one is beyond chance."""
    model, evidence = declared_model(), recorded()
    residual, rng, beyond, cells = find_residual(model, evidence), np.random.default_rng(1), 0, 0
    kernel = np.exp(-np.arange(25) / 5.0)
    for _ in range(2):
        white = rng.normal(size=(len(residual.dt) + 24, 4)) * noise_of(model.robot)
        noise = np.stack([np.convolve(white[:, j], kernel, 'valid') for j in range(4)], axis=1)
        found, _ = structures(model, model, replace(residual, residual=noise), evidence, WARMED)
        beyond += sum((found.share[name] > found.chance[name]).sum() for name in ORDER) \
            + (found.pairs > found.pairs_chance).sum()
        cells += len(ORDER) * 4 + 16
    assert beyond <= 0.03 * cells


def test_after_the_effect_was_added_nothing_is_left_of_it():
    """Shares after count of the structure before."""
    times = 4.0
    evidence, model = recorded(on(JOINT, times, viscous)), declared_model()
    speeds = np.concatenate([viscous(Hidden(model.robot, *run))[:, JOINT]
                             for run in clean_runs(SECONDS)])
    mean = model.mean.copy()
    mean[next(where.start for use, where in model.slices()
              if (use.name, use.joint) == ('viscous_friction', JOINT))] += \
        times * noise_of(model.robot)[JOINT] / np.sqrt(np.mean(speeds ** 2))
    before, after = told(evidence, better=replace(model, mean=mean))
    assert before.share['velocity'][JOINT] > 0.6
    assert all(after.share[name][JOINT] < 0.02 for name in ORDER)
    assert after.rms[JOINT] < 0.4 * before.rms[JOINT] and after.structured[JOINT] < 0.05
    np.testing.assert_array_equal(after.noise, before.noise)
    np.testing.assert_allclose(np.delete(after.rms, JOINT), np.delete(before.rms, JOINT))


def test_an_unchanged_model_is_not_looked_at_twice():
    before, after = told(recorded())
    assert after is before


def test_what_cannot_be_told_is_no_number():
    model, evidence = declared_model(), recorded()
    residual = find_residual(model, evidence)
    weights = residual.weights.copy()
    weights[:, OTHER] = 0.0
    before, _ = structures(model, model, replace(residual, weights=weights), evidence, (0,))
    np.testing.assert_array_equal(np.isnan(before.share[TEMPERATURE]), [False, True, True, True])
    assert np.isnan([before.share[name][OTHER] for name in ORDER]).all()
    assert np.isnan(before.rms[OTHER]) and np.isnan(before.pairs[OTHER]).all()
    assert np.isfinite(before.pairs[:OTHER]).all()


@pytest.mark.parametrize('function, variable', [(resonance, 'velocity'), (cable, 'position')])
def test_unknown_is_told_by_the_same_measure(function, variable):
    model = declared_model()
    residual = find_residual(model, recorded(on(JOINT, 4.0, function)))
    name, share = followed(model.robot, residual, residual.residual[:, JOINT], JOINT)
    assert name == variable and 0.6 < share <= 1.0


def test_a_function_is_judged_on_blocks_it_was_not_fitted_to():
    """As many functions as samples fit anything, and foretell nothing."""
    rng = np.random.default_rng(0)
    values, weights, starts = rng.normal(size=600), np.full(600, 2.0), np.arange(0, 600, 50)
    trial = Foretelling(values, weights, np.full(600, 0.02), starts, np.zeros((600, 0)))
    explained, chance = trial.explained(rng.normal(size=(600, 500)))
    assert explained < 0.0 <= chance
    told_, chance = trial.explained(values[:, None])
    assert told_ == pytest.approx(np.mean(values ** 2), rel=0.01) and chance < 0.2 * told_


def test_chance_does_not_depend_on_how_often_rows_come():
    """The same residual, every row in two halves: its noise is forgotten after as long."""
    rng = np.random.default_rng(0)
    values, weights, starts = rng.normal(size=6000), np.full(6000, 2.0), np.arange(0, 6000, 200)
    columns, none = hats(rng.normal(size=6000), 8), np.zeros((6000, 0))
    whole = Foretelling(values, weights, np.full(6000, 0.02), starts, none)
    halves = Foretelling(*(np.repeat(rows, 2, axis=0) for rows in (
        values, 0.5 * weights, np.full(6000, 0.01))), 2 * starts, np.repeat(none, 2, axis=0))
    np.testing.assert_allclose(halves.explained(np.repeat(columns, 2, axis=0)),
                               whole.explained(columns), rtol=1e-9)
