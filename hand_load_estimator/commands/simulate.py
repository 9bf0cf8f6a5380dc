"""`hand_load simulate`: a recording of the simulated arm."""

from ..simulation.simulate import add_arguments, EXAMPLE, run

__all__ = ['EXAMPLE', 'add_arguments', 'run']
