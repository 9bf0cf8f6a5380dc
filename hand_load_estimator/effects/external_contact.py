"""A push from outside; it belongs to no model, only to the time in which it acted."""

from .effect import Described

EXTERNAL_CONTACT = Described(
    'external_contact', 'something outside pushed the hand for a limited time, with one force F '
    'in the axes of the base: the drives hold - J^T F against it',
    'Haddadin, De Luca and Albu-Schaeffer 2017',
    tuple((f'force_{axis}', 'N') for axis in 'xyz'))
