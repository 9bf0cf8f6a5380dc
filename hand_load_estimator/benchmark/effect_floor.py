"""
What a torque error would be if all of a hidden effect were known: the yardstick of a diagnosis.

Between a diagnosis and the error without the effect stands what is none of its own. Friction
begins where a motion that nobody saw left it, and an effect may make the way long until that is
forgotten: only rows after it are judged here. A gain scales all torque, what the model never
explained too; a delay shows the torque of a moment when the joint may have stood. So the arm is
led along its own true motion without the effect (plant/led_plant.py), and the first model's error
of that torque is carried through gain and delay. A diagnosis may do better: it identifies all
else anew as well.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..motion import Motion
from ..plant import follow_motion, Plant
from ..plant.led_plant import LedPlant
from ..plant.run import JointEvent
from ..stream.joint_stream import JointStream
from .cases import stream_samples
from .effect_errors import differences, moving

# Ways of presliding after which what friction began with shows by less than 1 % of its level.
FORGOTTEN = 2.0


@dataclass(frozen=True)
class Floor:
    """
    Of one recording of N rows: left (N, n) [Nm] where the effect is known; rows (N, n) bool:
    moving joints whose friction has forgotten how it began; moving (N, n) bool: all that move.
    """

    left: np.ndarray
    rows: np.ndarray
    moving: np.ndarray


def floor_of(model, motion, effects, **arguments):
    """
    Return the Floor of a plant with EffectRequests led along a Trajectory.

    model: the TorqueModel of the same plant without them; arguments: as of Plant, of which the
    recording judged was made.
    """
    plant, led, events = led_along(model.robot, motion, effects, **arguments)
    measured, of_arm, of_noise = [], [], []
    for event in events:
        measured.append(event)
        known, noise = event, event
        if isinstance(event, JointEvent):
            constants = plant.truth.constants
            known = replace(event, effort=led.follow(plant) / constants)
            noise = replace(event, effort=event.effort - plant.reported_effort() / constants)
        of_arm.append(known)
        of_noise.append(noise)
    seen = _motion(model.robot, measured)
    error = differences(model, _motion(model.robot, of_arm))
    noise = _motion(model.robot, of_noise).effort * model.robot.effort.torque_constants
    left = _gain(plant, seen) * _delayed(error, seen.stamp, plant.truth.effort_delay) + noise
    moves = moving(seen)
    return Floor(left, moves & _forgotten(seen.q, plant.truth.friction.presliding), moves)


def led_along(robot, motion, effects, **arguments):
    """
    Return a Plant with EffectRequests, the LedPlant to be led along its motion, and its events.

    motion: the Trajectory it follows; arguments: as of Plant. The events come one by one.
    """
    arguments = {**arguments, 'start_position': np.array(motion.position[0], dtype=float)}
    plant = Plant(robot, effects=effects, **arguments)
    return plant, LedPlant(robot, **arguments), follow_motion(
        plant, motion.time, motion.position, motion.velocity, motion.acceleration)


def _motion(robot, events):
    return Motion.of(list(stream_samples(robot, events, JointStream(robot))))


def _gain(plant, motion):
    """Return what torque is multiplied with (N, n) before it is reported."""
    warmer = motion.temperature - plant.robot.reference_temperature
    return plant.truth.effort_gain + plant.truth.effort_gain_slope * warmer


def _delayed(error, stamp, delay):
    """Return errors (N, n) at stamps (N,) that come delay (n,) [s] later."""
    return np.stack([np.interp(stamp - late, stamp, column)
                     for late, column in zip(delay, error.T)], axis=1)


def _forgotten(q, presliding):
    """Return (N, n) bool: since the first row, joints have turned by FORGOTTEN x presliding."""
    seen = np.maximum.accumulate(q) - np.minimum.accumulate(q)
    return seen > FORGOTTEN * presliding
