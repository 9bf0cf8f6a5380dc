"""Lead a plant along a motion and hand out what its sensors say, in the order of time."""

from dataclasses import dataclass

import numpy as np

from .plant import Plant

TEMPERATURE_RATE = 10.0  # [Hz]


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
    anything is written.

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
        plant.step_until(stamp)
        if not started and stamp - begin >= settle:
            plant.set_trajectory(plant.robot.joints, time, position, velocity, acceleration)
            started = True
        yield JointEvent(plant.time, *plant.measure())
        if k % every == 0:
            yield TemperatureEvent(plant.time, plant.measure_temperatures())


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
