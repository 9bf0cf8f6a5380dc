"""Another load in the hand for a time; it belongs to no model, only to that time."""

from .effect import Described

LOAD_CHANGE = Described(
    'load_change', 'for a time another load hung on the hand than the recording declares. The '
    'mass is the change: negative where the declared load, or part of it, is gone',
    'Atkeson, An and Hollerbach 1986',
    (('mass', 'kg'), *((f'com_{axis}', 'm') for axis in 'xyz')))
