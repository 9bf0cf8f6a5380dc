"""Friction that grows with the torque of the gear."""

from .effect import Effect
from .own_travel import of_own_travel, OWN_TRAVEL, PLASTIC
from .shown_gear import shown_size


def direction(x, j, shape):
    """Return the state in [-1, 1], (N,) or (N, m), by which a share of the load is friction."""
    # As all friction it turns over the presliding travel, not with the sign of the velocity.
    return of_own_travel(x, j, shape, x.z[:, j])


def _columns(x, j, shape):
    return (shown_size(x.gear[:, j], x.gear_way[:, j]) * direction(x, j, shape))[..., None]


LOAD_DEPENDENT_FRICTION = Effect(
    'load_dependent_friction', 'tooth friction grows with the torque the gear carries',
    'Hamon et al. 2010', (('coefficient', '-'),), (0.1,), _columns, (OWN_TRAVEL, PLASTIC),
    against='gear torque',
    needs=frozenset({'gear', 'gear_way'}), absolute=True, positive=(0,))
