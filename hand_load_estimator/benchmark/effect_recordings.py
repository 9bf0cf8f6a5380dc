"""What is recorded of a plant: without load to diagnose and to test, with known loads to judge."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..identification.evidence import prepare
from ..identification.identify import identify
from ..load import LoadParameters
from ..motion import Motion
from ..robot import load_robot
from ..simulation.simulate_motions import named_motion
from .cases import case_run, draw_case, identification_evidence, Recorded, simulated, untold
from .effect_cases import load_seeds
from .effect_errors import mass_errors, torque_rmse
from .effect_floor import floor_of

# How the new arm is identified.
IDENTIFIED = Recorded()
# Motion, temperature [degC], seconds. The new arm was seen in these motions at the other's
# temperatures, and in other draws of them.
DIAGNOSED = (('pick_place', 15.0, 44.0), ('excite', 25.0, 44.0), ('pick_place', 36.0, 44.0),
             ('excite', 50.0, 44.0))
TESTED = (('excite', 20.0, 20.0), ('pick_place', 42.0, 20.0))
LOADED = 6
# identification_evidence draws its motions from seeds 10 x plant and the next three.
_FIRST_MOTION = 4


@dataclass(frozen=True)
class Recordings:
    """evidence, test: Evidence without load; loaded: (Case, CaseRun) with known loads."""

    evidence: tuple
    test: tuple
    loaded: tuple


@dataclass(frozen=True)
class NewArm:
    """
    A plant before anything happened to it: its model, and the errors that model makes on it.

    torque (n,) [Nm]; mass: errors [kg] as of mass_errors.
    """

    model: object
    torque: np.ndarray
    mass: dict


def record(robot, plant, effects=()):
    """Return the Recordings of a plant with hidden effects (EffectRequests)."""
    parts = [_evidence(robot, plant, k, *part, effects)
             for k, part in enumerate(DIAGNOSED + TESTED)]
    drawn = [draw_case(robot, plant, seed) for seed in load_seeds(plant, LOADED)]
    return Recordings(tuple(parts[:len(DIAGNOSED)]), tuple(parts[len(DIAGNOSED):]),
                      tuple((case, case_run(robot, case, effects)) for case in drawn))


def without_temperatures(recordings):
    """Return Recordings as of an arm without sensors of temperature."""
    evidence, test = (tuple(replace(e, motion=untold(e.motion)) for e in part)
                      for part in (recordings.evidence, recordings.test))
    return replace(recordings, evidence=evidence, test=test)


def tested_floors(model, plant, effects):
    """Return the Floors of a plant's test recordings; model: its TorqueModel without effects."""
    out = []
    for k, (name, temperature, seconds) in enumerate(TESTED, start=len(DIAGNOSED)):
        motion, arguments = _run(model.robot, plant, k, name, temperature, seconds)
        out.append(floor_of(model, motion, effects, **arguments))
    return out


def _run(robot, plant, k, name, temperature, seconds):
    """Return the Trajectory of recording k and the Plant's arguments in it."""
    motion = named_motion(name, robot, seconds, 1.0, 10 * plant + _FIRST_MOTION + k)
    return motion, {'seed': plant, 'run': _FIRST_MOTION + k, 'start_temperature': temperature}


def _evidence(robot, plant, k, name, temperature, seconds, effects):
    motion, arguments = _run(robot, plant, k, name, temperature, seconds)
    samples = simulated(robot, motion, effects=effects, **arguments)
    label = f'plant {plant}, {name} at {temperature:g} degC, {k + 1}'
    return prepare(robot, label, Motion.of(samples), LoadParameters())


# Cases come plant by plant: a worker needs the last plant's arm, seldom the one before.
@lru_cache(maxsize=2)
def new_arm(robot_path, plant):
    """Return the NewArm of a plant seed."""
    robot = load_robot(robot_path)
    model = identify(robot, identification_evidence(robot, plant, recorded=IDENTIFIED))
    without = record(robot, plant)
    return NewArm(model, torque_rmse(model, without.test), mass_errors(model, without.loaded))
