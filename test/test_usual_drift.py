"""How friction differs from day to day one recording does not show: a usual spread counts."""

from dataclasses import replace

from core_helpers import exact_model, four_axes, messages
import numpy as np
import pytest

from hand_load_estimator.identification import identify
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.identification.left_out_noise import noise_left_out
from hand_load_estimator.identification.residual_noise import USUAL_DRIFT
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import JointSample, Recording, TemperatureSample
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque_model import drift_std, UNKNOWN_WARMTH

EFFECTS = ('link_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')
WARMED = (*EFFECTS, 'temperature_dependent_viscous_friction')


def identified(monkeypatch, seeds, celsius=(), effects=EFFECTS):
    """Return the drift seen and stated (4, 3), and friction (4, 3), of a run per seed."""
    model, robot, evidence, seen = exact_model('four'), four_axes(), [], []
    for seed in seeds:
        stream = messages(model, LoadParameters(), 20.0, seed=seed)
        recording = Recording('made up', [
            sample for k, message in enumerate(stream) for sample in (
                *(TemperatureSample(message.stamp, joint, value)
                  for joint, value in zip(robot.joints, celsius) if k % 50 == 0),
                JointSample(message.stamp, message.names, message.position, message.velocity,
                            message.effort))])
        evidence.append(prepare(robot, f'run {seed}', motion_of(robot, recording)[0],
                                LoadParameters(), recording))

    def heard(*given):
        density, drift = noise_left_out(*given)
        seen.append(drift)
        return density, drift
    monkeypatch.setattr(identify, 'noise_left_out', heard)
    found = identify.identify(robot, evidence, list(effects))
    friction = np.stack([np.zeros(4), found.friction_level(), found.viscous_friction()], axis=1)
    return seen[0], found.residuals.drift, friction


def test_of_one_recording_it_is_at_least_the_usual_one(monkeypatch):
    seen, stated, friction = identified(monkeypatch, [1])
    np.testing.assert_allclose(stated, np.maximum(seen, USUAL_DRIFT * friction), rtol=1e-9)
    assert (stated[:, 2] > 2.0 * seen[:, 2]).all() and (stated[:, 0] == seen[:, 0]).all()


def test_of_more_it_counts_as_one_of_them(monkeypatch):
    seen, stated, friction = identified(monkeypatch, [1, 2, 3, 4])
    mixed = np.sqrt(0.75 * seen ** 2 + 0.25 * (USUAL_DRIFT * friction) ** 2)
    np.testing.assert_allclose(stated, np.maximum(seen, mixed), rtol=1e-9)
    assert (stated > seen).any() and (stated == seen).any()


def test_where_temperature_tells_it_only_what_is_seen_counts(monkeypatch):
    """Of the joints that have a sensor; what the others' friction does nobody knows."""
    seen, stated, friction = identified(monkeypatch, [1], (30.0, 30.0), WARMED)
    np.testing.assert_array_equal(stated[:2, 2], seen[:2, 2])
    np.testing.assert_allclose(stated[2:, 2], USUAL_DRIFT[2] * friction[2:, 2], rtol=1e-9)
    # There is no effect of temperature on Coulomb's level in this model.
    usual = USUAL_DRIFT[1] * friction[:, 1]
    np.testing.assert_allclose(stated[:, 1], np.maximum(seen[:, 1], usual), rtol=1e-9)


def test_where_temperature_is_lost_what_is_not_known_of_the_slope_counts():
    """Recordings of one temperature tell no slope: it may be any, and at run time matters."""
    model = exact_model('four')
    unknown = np.zeros(4, bool)
    places = {use.joint: where.start for use, where in model.slices()
              if use.name == 'temperature_dependent_viscous_friction'}
    mean, covariance = model.mean.copy(), model.covariance.copy()
    mean[places[1]], covariance[places[1], places[1]] = 0.0, 0.03 ** 2
    drift = drift_std(replace(model, mean=mean, covariance=covariance), unknown)
    assert drift[1, 2] == pytest.approx(np.hypot(model.residuals.drift[1, 2],
                                                 0.03 * UNKNOWN_WARMTH))
