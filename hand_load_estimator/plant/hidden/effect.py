"""What a hidden effect is: parameters, the torque it costs along a motion, where it acts."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """One parameter: unit, the range a file may set, entries when it is a vector."""

    unit: str
    low: float = -np.inf
    high: float = np.inf
    size: int = 1


class HiddenEffect:
    """
    One effect. Its torque is what the drives must supply (or report) because of it.

    name: as in the design; amplitude: the parameter that a strength sets; parameters: all of
    them; per_joint: they have one value per joint, not one for the arm; shared: many joints
    feel it, so that a strength counts at the joint that feels it most; linear: torque in
    proportion to the amplitude.
    """

    name = ''
    amplitude = ''
    parameters = {}
    per_joint = True
    shared = False
    linear = True

    def draw(self, rng, truth, motion):
        """Return the parameters beside the amplitude: (n,) each, or as the arm's one value."""
        return {}

    def bounds(self, truth):
        """Return the smallest and largest amplitude a strength may ask for, (n,) or scalar."""
        return 1e-9, np.inf

    def torque_along(self, motion, truth, p):
        """Return the torque (N, n) [Nm] along a ReferenceMotion."""
        raise NotImplementedError

    def apply(self, truth, p):
        """Write the effect with parameters p into the truth."""
        raise NotImplementedError


class FunctionTorque(HiddenEffect):
    """A torque that is a function of one variable alone: of(values (..., n), p)."""

    variable = 'position'

    def torque_along(self, motion, truth, p):
        """Return the function along the motion."""
        return self.of(motion.q if self.variable == 'position' else motion.v, p)

    def apply(self, truth, p):
        """Let it act on the joints."""
        truth.joint_torques.append(_Acting(self, p))


class _Acting:
    def __init__(self, effect, p):
        self._effect, self._p = effect, p

    def torque(self, now, dt):
        """Return the torque (n,) [Nm] asked of the drives in a Situation."""
        return self._effect.of(getattr(now, self._effect.variable), self._p)
