"""What is left of the torque error where the effect is known, whatever the effect is."""

import numpy as np
from plant_helpers import ur10e
import pytest

from hand_load_estimator.benchmark import effect_recordings
from hand_load_estimator.benchmark.cases import identification_evidence, Recorded
from hand_load_estimator.benchmark.effect_errors import rms, torque_rmse
from hand_load_estimator.benchmark.effect_floor import FORGOTTEN
from hand_load_estimator.identification.identify import identify
from hand_load_estimator.plant.effects_file import parse_effects

PLANT = 595


@pytest.fixture(scope='module')
def brief():
    """Record nothing but one short test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(effect_recordings, 'DIAGNOSED', ())
        patch.setattr(effect_recordings, 'TESTED', (('excite', 25.0, 9.0),))
        patch.setattr(effect_recordings, 'LOADED', 0)
        yield


@pytest.fixture(scope='module')
def model(brief):
    """Return the TorqueModel of a plant without effects."""
    return identify(ur10e(), identification_evidence(
        ur10e(), PLANT, recorded=Recorded((('excite', 20.0, 20.0), ('excite', 35.0, 20.0)))))


def floor(model, name=None, **entry):
    """
    Return RMS (n,) left where an effect of the elbow is known, and of what the model leaves.

    Further the rows that are judged and the recorded positions, (N, n) each.
    """
    effects = parse_effects([{'name': name, 'joints': ['elbow_joint'], **entry}] if name else [],
                            ur10e())
    (one,) = effect_recordings.tested_floors(model, PLANT, effects)
    recorded = effect_recordings.record(ur10e(), PLANT, effects).test
    return (rms([one.left], [one.rows]), torque_rmse(model, recorded), one.rows,
            recorded[0].motion.q)


@pytest.fixture(scope='module')
def clean(model):
    """Return what the model leaves of its own plant's torque (n,)."""
    known, left, *_ = floor(model)
    # Of the rows that friction is known in; no joint's first milliradians tell much.
    np.testing.assert_allclose(known, left, rtol=0.05)
    return known


@pytest.mark.parametrize('name', [
    'gravity_spring', 'torque_offset', 'stribeck_friction', 'rotor_inertia'])
def test_it_is_near_what_is_left_without_the_effect(model, clean, name):
    known, left, *_ = floor(model, name, strength=3.0)
    assert left[2] > 1.5 * clean[2]
    # The motion differs a little, and with it what the model leaves.
    np.testing.assert_allclose(known, clean, rtol=0.08)


def test_a_gain_scales_what_the_model_never_explained(model, clean):
    known, left, *_ = floor(model, 'torque_scale', parameters={'gain': 1.0})
    # Twice the model's own error, but the noise, which comes after the gain, once.
    assert 1.2 * clean[2] < known[2] < 2.0 * clean[2] < left[2]


def test_a_delay_shows_the_error_of_another_moment(model, clean):
    known, left, *_ = floor(model, 'time_delay', parameters={'delay': 0.06})
    assert left[2] > 2.5 * clean[2] and known[2] < 1.5 * clean[2]


def test_rows_begin_when_friction_has_forgotten_how_it_began(model, clean):
    travel = 0.2
    known, left, rows, q = floor(model, 'presliding_hysteresis', parameters={'distance': travel})
    first = int(np.argmax(rows[:, 2]))
    assert first > np.argmax(rows[:, 3])
    assert np.ptp(q[:first + 1, 2]) == pytest.approx(FORGOTTEN * travel, rel=0.1)
    assert known[2] < 1.1 * clean[2] and left[2] > 2.0 * clean[2]
