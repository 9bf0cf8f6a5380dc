"""Effects in the torque that planning asks for."""

from core_helpers import four_axes
from effect_helpers import model_with
import numpy as np
import pytest

from hand_load_estimator.effects import EFFECTS


def test_planning_knows_the_effects_too():
    """TorqueModel.torque: base tilt counts while the arm stands, a delay does not."""
    tilted = model_with(four_axes(), ('base_tilt', 'time_delay'),
                        {'base_tilt': (0.02, 0.0), 'time_delay': (1.0,)})
    plain = model_with(four_axes(), ('base_tilt', 'time_delay'),
                       {'base_tilt': (0.0, 0.0), 'time_delay': (0.0,)})
    q, zero = np.array([0.3, 0.5, -0.7, 0.9]), np.zeros(4)
    angles = np.array([0.02, 0.0])
    expected = tilted.robot.tilt_regressor(q, tilted.robot.nominal_links, angles) @ angles
    np.testing.assert_allclose(tilted.torque(q, zero, zero) - plain.torque(q, zero, zero),
                               expected, atol=1e-12)
    assert np.abs(expected).max() > 0.05


@pytest.mark.parametrize('name', sorted(set(EFFECTS) - {'learned_correction'}))
def test_torques_of_many_motions_are_those_of_each(name):
    effect, rng = EFFECTS[name], np.random.default_rng(5)
    model = model_with(four_axes(), (name,), {name: rng.normal(size=len(effect.parameters))}, {
        s.name: s.grid[0] if s.grid else 20.0 for s in effect.shapes})
    motions = [rng.normal(size=(7, 4)) for _ in range(3)]
    warmth = rng.uniform(15.0, 45.0, (7, 4))
    warmth[2, 1] = np.nan
    for temperature in (warmth, None):
        many = model.torques(*motions, temperature)
        each = [model.torque(*row, None if temperature is None else temperature[k])
                for k, row in enumerate(zip(*motions))]
        np.testing.assert_allclose(many, each, atol=1e-12)
