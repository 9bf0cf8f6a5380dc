"""Forces on the hand from outside: a contact for a while, a load that swings."""

import numpy as np

from .effect import HiddenEffect, Parameter

_RAMP = 0.05  # [s] in which a contact rises and falls


class ExternalContact(HiddenEffect):
    """
    A push at the load frame's origin, from `start` for `duration` [s], direction in the base.

    A strength is stated while in contact, not over the whole motion.
    """

    name, amplitude = 'external_contact', 'force'
    parameters = {'force': Parameter('N', 0.0), 'direction': Parameter('-', size=3),
                  'start': Parameter('s', 0.0), 'duration': Parameter('s', 0.0)}
    per_joint, shared = False, True

    def draw(self, rng, truth, motion):
        """Return a direction, and half a second from the fourth second on."""
        direction = rng.standard_normal(3)
        return {'direction': direction / np.linalg.norm(direction), 'start': 4.0,
                'duration': 0.5}

    def torque_along(self, motion, truth, p):
        """Return the torque of the full push all along the motion."""
        _, _, jacobians = motion.hands()
        return -p['force'] * np.einsum('i,kin->kn', p['direction'], jacobians)

    def apply(self, truth, p):
        """Let it act on the hand."""
        truth.forces.append(_Push(p))


class _Push:
    def __init__(self, p):
        self.at_most = p['force'] * np.asarray(p['direction'])
        self._start, self._end = p['start'], p['start'] + p['duration']

    def force(self, time, place, rotation, dt):
        """Return the force (3,) [N] on the hand, in base axes, of a step."""
        rise = min(time - self._start, self._end - time) / _RAMP
        return self.at_most * min(max(rise, 0.0), 1.0)


class SwingingLoad(HiddenEffect):
    """
    Part of the load swings (a liquid, a hanging part): no rigid load behaves so.

    A mass on a damped spring at the load frame's origin; its weight counts as the load's.
    """

    name, amplitude = 'swinging_load', 'mass'
    parameters = {'mass': Parameter('kg', 0.0), 'frequency': Parameter('Hz', 0.05, 20.0),
                  'damping': Parameter('-', 0.0, 1.0)}
    per_joint, shared = False, True

    def draw(self, rng, truth, motion):
        """Return a slow, weakly damped swing."""
        return {'frequency': rng.uniform(0.8, 1.6), 'damping': 0.03}

    def torque_along(self, motion, truth, p):
        """Return the torque of the swinging mass along the motion."""
        places, rotations, jacobians = motion.hands()
        mass = _Swing(p)
        forces = [mass.force(t, place, rotation, motion.dt)
                  for t, place, rotation in zip(motion.time, places, rotations)]
        return -np.einsum('ki,kin->kn', forces, jacobians)

    def apply(self, truth, p):
        """Hang it on the hand."""
        truth.forces.append(_Swing(p))


class _Swing:
    def __init__(self, p):
        self.frequency = p['frequency']
        self._mass, self._omega = p['mass'], 2.0 * np.pi * self.frequency
        self._damping = 2.0 * p['damping'] * self._omega
        self._place = None
        self._speed, self._hand = np.zeros(3), np.zeros(3)

    def force(self, time, place, rotation, dt):
        """Return the force (3,) [N] on the hand, in base axes, of a step."""
        if self._place is None:
            self._place, self._hand = place.copy(), place.copy()
        hand_speed = (place - self._hand) / dt
        self._hand = place.copy()
        pull = (self._omega ** 2 * (place - self._place)
                + self._damping * (hand_speed - self._speed))
        self._speed = self._speed + dt * pull
        self._place = self._place + dt * self._speed
        return -self._mass * pull
