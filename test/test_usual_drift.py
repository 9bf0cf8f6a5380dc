"""How friction differs from day to day one recording does not show: a usual spread counts."""

from core_helpers import exact_model, four_axes, messages, recording_of
import numpy as np
import pytest

from hand_load_estimator.evidence import prepare
from hand_load_estimator.identification import identify
from hand_load_estimator.joint_stream import motion_of
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.residual_noise import USUAL_DRIFT

EFFECTS = ('link_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')


def drift(seeds, celsius=np.nan, effects=EFFECTS):
    """Return the drift (4, 3) and friction (4, 3) of a model identified from a run per seed."""
    model, robot, evidence = exact_model('four'), four_axes(), []
    for seed in seeds:
        recording = recording_of(messages(model, LoadParameters(), 20.0, seed=seed), robot.joints,
                                 celsius)
        evidence.append(prepare(robot, f'run {seed}', motion_of(robot, recording)[0],
                                LoadParameters(), recording))
    found = identify(robot, evidence, list(effects))
    viscous = [found.mean[where.start] for use, where in found.slices()
               if use.name == 'viscous_friction']
    return found.residuals.drift, np.stack([np.zeros(4), found.friction_level(), viscous], axis=1)


@pytest.fixture(scope='module')
def alone():
    return drift([1])


def test_of_one_recording_it_is_the_usual_one(alone):
    np.testing.assert_allclose(alone[0], USUAL_DRIFT * alone[1], rtol=1e-9)


def test_of_more_it_counts_as_one_of_them(alone):
    """The same friction in four runs: half of it is left."""
    found, friction = drift([1, 2, 3, 4])
    assert (found[:, 2] >= 0.5 * USUAL_DRIFT[2] * friction[:, 2]).all()
    assert (found[:, 2] < 0.7 * USUAL_DRIFT[2] * friction[:, 2]).all()


def test_where_temperature_tells_it_only_what_is_seen_counts():
    found, friction = drift([1], 30.0, (*EFFECTS, 'temperature_dependent_viscous_friction'))
    usual = USUAL_DRIFT * friction
    assert (np.abs(found - usual)[:, 1:] > 0.05 * usual[:, 1:]).all()
