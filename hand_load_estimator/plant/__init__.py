"""The only room that simulates: arm, drives, friction, heat, hidden effects, sensors."""

from .effects_file import read_effects
from .plant import Plant
from .run import (follow_motion, JointEvent, refuse_runaway, simulate_motion,
                  TemperatureEvent)
from .setpoint import TrajectoryError

__all__ = ['JointEvent', 'Plant', 'TemperatureEvent', 'TrajectoryError', 'follow_motion',
           'read_effects', 'refuse_runaway', 'simulate_motion']
