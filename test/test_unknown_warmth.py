"""What a joint without a temperature sensor may be off by: the friction of any temperature."""

from dataclasses import replace

from core_helpers import exact_model
import numpy as np
import pytest

from hand_load_estimator.torque.columns import EffectUse
from hand_load_estimator.torque_model import drift_std, UNKNOWN_WARMTH

COULOMB, VISCOUS = (f'temperature_dependent_{kind}_friction' for kind in ('coulomb', 'viscous'))


def warmed_model():
    """Return a TorqueModel whose friction of both kinds changes with temperature."""
    model = exact_model('four')
    uses = tuple(EffectUse(COULOMB, use.joint) if use.name == 'torque_offset' else use
                 for use in model.uses)
    return replace(model, uses=uses, mean=np.linspace(1.0, 2.0, len(model.mean)))


@pytest.mark.parametrize('name, place', [(COULOMB, 1), (VISCOUS, 2)])
def test_a_slope_with_temperature_is_doubt_where_none_is_measured(name, place):
    model, known = warmed_model(), np.array([True, False, True, False])
    drift, stated = drift_std(model, known), model.residuals.drift
    np.testing.assert_array_equal(drift[known], stated[known])
    slopes = {use.joint: model.mean[where.start] for use, where in model.slices()
              if use.name == name}
    for joint in np.flatnonzero(~known):
        assert drift[joint, place] == pytest.approx(
            np.hypot(stated[joint, place], slopes[joint] * UNKNOWN_WARMTH))
    np.testing.assert_array_equal(drift[:, 0], stated[:, 0])
