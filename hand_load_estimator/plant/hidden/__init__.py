"""Effects the default plant does not have, switched on by name from an effects file."""

from .apply import apply_effects, EFFECTS

__all__ = ['EFFECTS', 'apply_effects']
