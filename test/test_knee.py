"""Friction that levels off with temperature: its columns, its fit, its search, its file."""

from dataclasses import replace
from functools import lru_cache

from core_helpers import effect_uses, four_axes, true_parameters
from effect_helpers import waves
import numpy as np
import pytest
import yaml

from hand_load_estimator.effects import DEFAULT_EFFECTS, EFFECTS, EffectInput
from hand_load_estimator.effects.knee import shows
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.identification.knee_fit import with_knees_fitted
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.torque.columns import (ColumnLayout, EffectUse, effect_slices,
                                                parameter_count, presliding_distances,
                                                torque_columns)
from hand_load_estimator.torque.model_file import read_model, write_model
from hand_load_estimator.torque.motion_inputs import motion_input
from hand_load_estimator.torque_model import Residuals, TorqueModel

COULOMB = 'temperature_dependent_coulomb_friction'
VISCOUS = 'temperature_dependent_viscous_friction'
JOINT, KNEE, SECONDS = 1, 11.0, 6.0
CELSIUS = (15.0, 25.0, 30.0, 34.0, 40.0, 50.0, 20.0, 45.0)


def arm(knee=np.inf, fall=0.0, name=COULOMB):
    """Return the TorqueModel of an arm whose joint loses friction, `fall` of its noise per K."""
    robot = four_axes()
    uses = (*effect_uses(robot), EffectUse(COULOMB, JOINT))
    x = np.append(true_parameters(robot, uses[:-1]), 0.0)
    noise = 4e-3 * robot.limits.torque
    for k, (use, where) in enumerate(effect_slices(robot.n, uses)):
        if (use.name, use.joint) == (name, JOINT):
            uses = (*uses[:k], EffectUse(name, JOINT, {'knee': knee}), *uses[k + 1:])
            x[where.start] -= fall * noise[JOINT]
    std = 0.01 * np.abs(x)
    std[:10 * robot.n], std[-1] = 0.0, 1e-4 * noise[JOINT]
    return TorqueModel(robot, uses, False, x, np.diag(std ** 2), Residuals(
        noise, noise ** 2 * 0.02, np.zeros((robot.n, 3))), (RecordingMark('made up'),),
        (15.0, 50.0))


@lru_cache(None)
def recorded(knee, fall, name=COULOMB):
    """Return the Evidence of an arm at several temperatures."""
    model, rng, out = arm(knee, fall, name), np.random.default_rng(3), []
    distance = presliding_distances(model.robot.n, model.uses)
    for celsius in CELSIUS:
        motion = waves(model.robot, rng, SECONDS, celsius)
        x, _ = motion_input(model.robot, motion, distance, level=model.contact_level())
        torque = torque_columns(model.robot, model.layout, x) @ model.mean
        out.append(Evidence(f'at {celsius:g}', motion,
                            torque + rng.normal(size=torque.shape) * model.noise))
    return tuple(out)


@lru_cache(None)
def diagnosed(knee, fall, name=COULOMB):
    """Return (Diagnosis, better model) of the straight, healthy model; two runs are to test."""
    evidence = recorded(knee, fall, name)
    return diagnose(arm(), list(evidence[:6]), list(evidence[6:]))


# Columns.

@pytest.mark.parametrize('name', [COULOMB, VISCOUS])
def test_friction_falls_to_its_knee_and_stays(name):
    warmth = np.linspace(-20.0, 40.0, 61)[:, None]
    one = np.ones_like(warmth)
    x = EffectInput(one, 0.5 * one, one, warmth, one)
    effect = EFFECTS[name]
    straight, bent = (effect.columns(x, 0, {'knee': knee}) for knee in (np.inf, KNEE))
    below = warmth[:, 0] <= KNEE
    np.testing.assert_array_equal(bent[below], straight[below])
    np.testing.assert_allclose(bent[~below], np.broadcast_to(bent[below][-1],
                                                             bent[~below].shape))
    assert effect.default_shape() == {'knee': np.inf} and name in DEFAULT_EFFECTS


@pytest.mark.parametrize('warmth, told', [
    (np.linspace(-10.0, 25.0, 99), True), (np.repeat([-10.0, 10.0], 50), False),
    (np.repeat([-10.0, 3.0, 25.0], 50), True), (np.linspace(-10.0, 10.5, 99), False),
    (np.linspace(11.5, 30.0, 99), False), (np.zeros(0), False)])
def test_a_knee_shows_only_where_the_fall_and_the_level_do(warmth, told):
    assert shows(warmth, KNEE) == told


# The fit beside all other parameters.

def test_a_knee_is_fitted_with_its_doubt():
    """From 4 K away; the slope is known less well than if the knee were known."""
    model = arm(KNEE + 4.0, 0.3)
    mean, prior = arm().mean, np.diag(np.full(len(model.mean), 1.0))
    prior[:10 * model.robot.n] = 0.0
    system = System(model.robot, model.uses, recorded(KNEE, 0.3), mean)
    weights = system.weights(model.residuals.intensity, model.friction_level())
    uses, x, covariance = with_knees_fitted(system, model.uses, model.uses, mean, prior,
                                            weights)
    knee, std = uses[-1].shape['knee'], uses[-1].shape_std['knee']
    assert abs(knee - KNEE) < 4.0 * std and 0.01 < std < 0.5
    slope, doubt = x[-1], np.sqrt(covariance[-1, -1])
    assert abs(slope + 0.3 * model.noise[JOINT]) < 4.0 * doubt
    np.testing.assert_allclose(system.columns, System(model.robot, uses, recorded(KNEE, 0.3),
                                                      mean).columns)
    _, known = system.solve(mean, prior, weights)
    assert doubt > 1.05 * np.sqrt(known[-1, -1])
    np.testing.assert_array_equal(uses[:-1], model.uses[:-1])


def test_what_was_known_of_a_knee_stays_known_where_recordings_do_not_reach_it():
    model = arm(KNEE, 0.3)
    known = (*model.uses[:-1], EffectUse(COULOMB, JOINT, {'knee': KNEE}, {'knee': 0.7}))
    system = System(model.robot, known, recorded(KNEE, 0.3)[:3], model.mean)
    weights = system.weights(model.residuals.intensity, model.friction_level())
    uses, _, _ = with_knees_fitted(system, known, known, model.mean, model.covariance, weights)
    assert uses[-1].shape['knee'] == pytest.approx(KNEE, abs=1e-6)
    assert uses[-1].shape_std['knee'] == pytest.approx(0.7)


def test_without_a_knee_the_fit_is_the_plain_one():
    model = arm()
    evidence = recorded(np.inf, 0.1)
    system = System(model.robot, model.uses, evidence, model.mean)
    weights = system.weights(model.residuals.intensity, model.friction_level())
    uses, x, covariance = with_knees_fitted(system, model.uses, model.uses, model.mean,
                                            model.covariance, weights)
    plain = system.solve(model.mean, model.covariance, weights)
    assert uses == model.uses
    np.testing.assert_array_equal(x, plain[0])
    np.testing.assert_array_equal(covariance, plain[1])


# The search.

@pytest.mark.parametrize('name, fall', [(COULOMB, 0.4), (VISCOUS, 1.5)])
def test_a_knee_is_found(name, fall):
    diagnosis, better = diagnosed(KNEE, fall, name)
    found, = diagnosis.findings
    assert (found.name, found.joints) == (name, (better.robot.joints[JOINT],))
    mean, std, unit = found.parameters['knee']
    assert abs(mean - KNEE) < 4.0 * std + 0.1 and std < 1.0 and unit == 'K'
    noise = better.noise[JOINT]
    assert diagnosis.before[JOINT] > 1.5 * noise and diagnosis.after[JOINT] < 1.05 * noise
    picture, = found.pictures
    assert 'levels off at' in picture.variable
    hot = picture.x > 25.0 + KNEE + 3.0
    assert hot.any() and np.ptp(picture.curve[hot]) < 0.3 * np.ptp(picture.curve)


def test_a_straight_fall_stays_straight():
    diagnosis, better = diagnosed(np.inf, 0.1)
    found, = diagnosis.findings
    assert found.name == COULOMB and 'knee' not in found.parameters
    assert better.uses == arm().uses and 'levels off' not in found.pictures[0].variable


@pytest.mark.parametrize('before, now', [(KNEE, np.inf), (KNEE, 20.0)])
def test_a_knee_that_moved_or_went_is_found(before, now):
    """Friction falls as steeply as ever, but to another temperature."""
    evidence, model = recorded(now, 0.3), arm(before, 0.3)
    diagnosis, better = diagnose(model, list(evidence[:6]), list(evidence[6:]))
    found, = diagnosis.findings
    assert (found.name, found.joints) == (COULOMB, (better.robot.joints[JOINT],))
    noise = better.noise[JOINT]
    assert diagnosis.before[JOINT] > 1.5 * noise and diagnosis.after[JOINT] < 1.05 * noise
    assert better.mean[-1] == pytest.approx(-0.3 * noise, rel=0.1)
    assert better.uses[-1].shape['knee'] == pytest.approx(now, abs=1.5)


def test_a_knee_that_recordings_do_not_reach_stays_where_it_was():
    """They are colder than it, and tell of a steeper fall only."""
    model = arm(20.0, 0.3)
    known = EffectUse(COULOMB, JOINT, {'knee': 20.0}, {'knee': 0.7})
    model = replace(model, uses=(*model.uses[:-1], known))
    evidence = recorded(np.inf, 0.9)[:4]
    diagnosis, better = diagnose(model, list(evidence[:3]), list(evidence[3:]))
    found, = diagnosis.findings
    assert found.name == COULOMB
    assert better.mean[-1] == pytest.approx(-0.9 * model.noise[JOINT], rel=0.2)
    assert better.uses[-1].shape['knee'] == pytest.approx(20.0, abs=1e-6)
    assert 0.7 <= better.uses[-1].shape_std['knee'] < 3.0


@pytest.mark.parametrize('knee', [np.inf, KNEE])
def test_identification_finds_a_knee_where_there_is_one(knee):
    names = [*dict.fromkeys(use.name for use in arm().uses)]
    model = identify(arm().robot, list(recorded(knee, 0.4)), names)
    told = {(use.name, use.joint): use.told_shape.get('knee') for use in model.uses}
    assert told.pop((COULOMB, JOINT)) == (
        None if np.isinf(knee) else pytest.approx(KNEE, abs=0.5))
    assert all(value is None for (name, _), value in told.items() if name in (COULOMB, VISCOUS))


# The file.

def test_the_knee_and_its_doubt_go_into_the_file_and_back(tmp_path):
    _, better = diagnosed(KNEE, 0.4, COULOMB)
    path = tmp_path / 'model.yaml'
    write_model(path, better)
    back = read_model(path)
    assert back.uses == better.uses and back.uses[-1].shape_std['knee'] > 0.0
    shape = (5, better.robot.n)
    x = EffectInput(*np.random.default_rng(0).uniform(-1.0, 1.0, (3, *shape)),
                    np.full(shape, 30.0), np.ones(shape))
    columns = [torque_columns(m.robot, m.layout, x) for m in (better, back)]
    np.testing.assert_array_equal(*columns)
    assert columns[1][0, JOINT, -1] == pytest.approx(KNEE, abs=1.0)


def test_a_straight_line_is_not_mentioned_in_the_file(tmp_path):
    path = tmp_path / 'model.yaml'
    write_model(path, arm())
    entries = yaml.safe_load(path.read_text())['effects']
    assert not any('shape' in e for e in entries if e['name'] in (COULOMB, VISCOUS))
    assert read_model(path).uses == arm().uses
    assert parameter_count(4, arm().uses) == len(arm().mean) == ColumnLayout(4, arm().uses).size
