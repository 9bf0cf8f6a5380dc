"""Effects in the torque that planning asks for."""

from core_helpers import four_axes
from effect_helpers import model_with
import numpy as np


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
