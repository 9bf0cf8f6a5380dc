"""A torque model is of one arm: read it only for that one."""

import numpy as np
import pinocchio as pin

from ..errors import ConfigurationError
from ..files.same_arm import arm_difference
from .model_file import read_model

# Nearer than this they are the same, written with other digits or calibrated (gravity: 0.015 rad).
SAME_FRAME, SAME_GRAVITY = 1e-3, 0.15      # [m and rad], [m/s^2]


def model_of_robot(path, robot):
    """
    Return the TorqueModel of a file for a Robot, whatever its limits were then.

    Raises ConfigurationError where joints, where they lie, effort kind, the lag of commanded
    positions, torque constants, configured load, load frame, gravity or reference temperature are
    not the robot's.
    """
    model = read_model(path)
    own = model.robot
    if own.joints != robot.joints or own.effort.kind != robot.effort.kind:
        raise ConfigurationError(
            f'model {path}', 'belongs to another robot',
            f'{own.name}: {", ".join(own.joints)}; {own.effort.kind}',
            f'{robot.name}: {", ".join(robot.joints)}; {robot.effort.kind}')
    apart = arm_difference(own, robot)
    if apart:
        raise ConfigurationError(
            f'model {path}', 'belongs to another robot', f'{own.name}: {apart}',
            f'{robot.name}, calibrated or not', 'identify a model of this one')
    for key, found, wanted in _otherwise(own, robot):
        raise ConfigurationError(
            f'model {path}', f'was identified with another `{key}` in the robot file', found,
            wanted, 'identify again, with the robot file as it is')
    return model


def other_limits(own, robot):
    """
    Return [a sentence] on limits of a model's Robot that are not today's robot file's, or [].

    Estimates go on with the model's: what was learned is scaled by them.
    """
    files = own.file, robot.file
    names = [name for name in ('max_velocity', 'max_acceleration', 'max_torque') if not
             np.array_equal(*(getattr(file, name) for file in files))]
    if not np.array_equal(*(file.rated_load.to_message() for file in files)):
        names.append('rated_load')
    return [f'estimates count with {", ".join(names)} as the model file has it, not as the robot '
            'file does now; identify again to change that'] if names else []


def _otherwise(own, robot):
    """Yield (key, model's, robot's) of what both robot files say, and say otherwise."""
    if own.file.command_lag != robot.file.command_lag:
        yield 'position', f'lag {own.file.command_lag} s', f'lag {robot.file.command_lag} s'
    told = [_effort(arm) for arm in (own, robot)]
    if told[0] != told[1]:
        yield 'effort', *told
    between = pin.log6(own.load_placement.actInv(robot.load_placement)).vector
    if np.abs(between).max() > SAME_FRAME:
        yield 'load_frame', *(_place(arm) for arm in (own, robot))
    # As the first link feels it: the base of a hanging arm may be turned in its URDF instead.
    felt = [arm.model.jointPlacements[1].rotation.T @ arm.model.gravity.linear
            for arm in (own, robot)]
    if np.abs(felt[0] - felt[1]).max() > SAME_GRAVITY:
        yield 'gravity', *(f'{g.round(2).tolist()} m/s^2 on the first link' for g in felt)
    if own.reference_temperature != robot.reference_temperature:
        yield 'reference_temperature', *(
            f'{arm.reference_temperature} degC' for arm in (own, robot))


def _effort(robot):
    """Return in words how a Robot turns efforts into torques."""
    configured = robot.effort.configured_load
    carried = 'none' if configured is None else configured.to_products().round(6).tolist()
    return (f'torque_constants {np.round(robot.effort.torque_constants, 6).tolist()}, '
            f'configured_load {carried}')


def _place(robot):
    place = robot.load_placement
    return (f'{robot.load_frame}, {(1e3 * place.translation).round(1).tolist()} mm and '
            f'{pin.log3(place.rotation).round(3).tolist()} rad from {robot.joints[-1]}')
