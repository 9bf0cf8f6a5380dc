"""Lead a plant along a motion and hand out what its sensors say, in the order of time."""

from dataclasses import dataclass

import numpy as np

from ..errors import ConfigurationError
from .plant import Plant

TEMPERATURE_RATE = 10.0  # [Hz]
_RUNAWAY = 100.0  # times max_velocity; an arm in free fall stays far below


@dataclass(frozen=True)
class JointEvent:
    """Joint states at one moment: stamp [s]; position, velocity, effort (n,)."""

    stamp: float
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray


@dataclass(frozen=True)
class TemperatureEvent:
    """Joint temperatures at one moment: stamp [s]; celsius (n,) [degC]."""

    stamp: float
    celsius: np.ndarray


def simulate_motion(robot, time, position, velocity=None, acceleration=None, *, settle=0.5,
                    load_changes=(), **plant_arguments):
    """
    Return the JointEvents and TemperatureEvents, one by one, of a new Plant led along a motion.

    The Plant is built and shown the motion at once, so that what it refuses is refused before
    anything is written. ConfigurationError on the way where the integration comes apart.

    time (k,) [s] from the motion's start; position, velocity, acceleration (k, n) as
    Plant.set_trajectory takes them. The arm stands at the first position for `settle` [s]
    before it moves; stamps count from the beginning of that. load_changes: (stamp, load) pairs
    in order of time. plant_arguments: as of Plant (seed, load, effects, start_temperature, ...).
    """
    plant = Plant(robot, start_position=np.array(position[0], dtype=float), **plant_arguments)
    plant.refuse_trajectory(robot.joints, time, position, velocity, acceleration)
    return follow_motion(plant, time, position, velocity, acceleration, settle=settle,
                         load_changes=load_changes)


def follow_motion(plant, time, position, velocity=None, acceleration=None, *, settle=0.5,
                  load_changes=()):
    """Yield the events of a Plant that stands at the motion's start; see simulate_motion."""
    changes = list(load_changes)
    begin = plant.time
    samples = int(round((settle + time[-1]) * plant.rate))
    every = max(1, int(round(plant.rate / TEMPERATURE_RATE)))
    started = False
    for k in range(samples + 1):
        stamp = begin + k / plant.rate
        while changes and changes[0][0] <= stamp - begin:
            plant.attach(changes.pop(0)[1])
        # What overflows is told below, in one sentence.
        with np.errstate(all='ignore'):
            plant.step_until(stamp)
        refuse_runaway(plant)
        if not started and stamp - begin >= settle:
            plant.set_trajectory(plant.robot.joints, time, position, velocity, acceleration)
            started = True
        yield JointEvent(plant.time, *plant.measure())
        if k % every == 0:
            yield TemperatureEvent(plant.time, plant.measure_temperatures())


def refuse_runaway(plant):
    """Raise ConfigurationError where the integration has come apart: no arm moves so."""
    _, velocity, _, torque = plant.state()
    share = np.abs(velocity) / plant.robot.limits.velocity
    if (share <= _RUNAWAY).all() and np.isfinite(torque).all():
        return
    joint = int(np.argmax(np.nan_to_num(share, nan=np.inf)))
    raise ConfigurationError(
        f'simulated arm at {plant.time:.2f} s', f'{plant.robot.joints[joint]} runs away',
        f'{velocity[joint]:.3g} rad/s', f'up to {_RUNAWAY:g} times max_velocity',
        'make effects weaker that are too stiff for steps of a millisecond; without any, compare '
        'masses and inertias of the URDF with max_torque')


def collect(events):
    """
    Return arrays of events: time (N,), position, velocity, effort, temperature (N, n).

    temperature is the last one reported at each moment.
    """
    rows, temperatures, celsius = [], [], None
    for event in events:
        if isinstance(event, TemperatureEvent):
            celsius = event.celsius
            temperatures = [celsius if t is None else t for t in temperatures]
        else:
            rows.append(event)
            temperatures.append(celsius)
    return (np.array([row.stamp for row in rows]), np.array([row.position for row in rows]),
            np.array([row.velocity for row in rows]), np.array([row.effort for row in rows]),
            np.array(temperatures))
