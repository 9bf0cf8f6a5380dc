"""A link that is not what the URDF says; its columns are the rigid body's own."""

from ..load import PRODUCT_ORDER
from .effect import Described

_UNITS = ('kg',) + ('kg m',) * 3 + ('kg m^2',) * 6

LINK_INERTIA = Described(
    'link_inertia', 'mass, centre of mass or inertia of a link differ from the model\'s: the '
    'torque is linear in the ten products of mass, first and second moments',
    'Atkeson, An and Hollerbach 1986',
    tuple((f'change_of_{name}', unit) for name, unit in zip(PRODUCT_ORDER, _UNITS)))
