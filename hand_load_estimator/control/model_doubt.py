"""What the torque model itself may be wrong by: parameters, drift, joints of unknown warmth."""

import numpy as np

from ..effects import EffectInput
from ..torque.columns import torque_columns, warmth_of
from ..torque_model import drift_std, nuisance_columns, uncertain_directions

_DIRECTIONS = 12  # of the parameters; as many as the estimators follow


class ModelDoubt:
    """Standard deviation of a TorqueModel's torque along a motion."""

    def __init__(self, model):
        self._model = model
        self._uncertain = uncertain_directions(model, _DIRECTIONS, seed=0)

    def std(self, q, v, a, temperature):
        """Return it (n,) [Nm] at a state of motion; temperature (n,) [degC], NaN where unknown."""
        model = self._model
        direction = np.where(v < 0.0, -1.0, 1.0)
        x = EffectInput(*(s[None] for s in (q, v, a, warmth_of(model.robot, temperature),
                                            direction)))
        columns = nuisance_columns(torque_columns(model.robot, model.layout, x, model.mean),
                                   self._uncertain, drift_std(model, np.isfinite(temperature)),
                                   x.z, x.v)
        return np.sqrt((columns[0] ** 2).sum(axis=1))


def unknown_warmth_std(model, temperature):
    """
    Return (n,) [Nm s/rad]: standard deviation of viscous friction for want of a temperature.

    temperature (n,) [degC]; 0 for the joints whose temperature is known.
    """
    known = drift_std(model, np.ones(model.robot.n, dtype=bool))[:, 2]
    now = drift_std(model, np.isfinite(temperature))[:, 2]
    return np.sqrt(np.maximum(now ** 2 - known ** 2, 0.0))
