"""A torque model is of one arm: read it only for that one."""

from ..errors import ConfigurationError
from ..files.same_arm import arm_difference
from .model_file import read_model


def model_of_robot(path, robot):
    """
    Return the TorqueModel of a file for a Robot, whatever its limits were then.

    Raises ConfigurationError where joints, where they lie, effort kind or the lag of commanded
    positions are not the robot's.
    """
    model = read_model(path)
    own = model.robot
    if own.joints != robot.joints or own.effort.kind != robot.effort.kind:
        raise ConfigurationError(
            f'model {path}', 'belongs to another robot',
            f'{own.name}: {", ".join(own.joints)}; {own.effort.kind}',
            f'{robot.name}: {", ".join(robot.joints)}; {robot.effort.kind}')
    if own.file.command_lag != robot.file.command_lag:
        raise ConfigurationError(
            f'model {path}', 'was identified with another `position` in the robot file',
            f'lag {own.file.command_lag} s', f'lag {robot.file.command_lag} s',
            'identify again, with the robot file as it is')
    apart = arm_difference(own, robot)
    if apart:
        raise ConfigurationError(
            f'model {path}', 'belongs to another robot', f'{own.name}: {apart}',
            f'{robot.name}, calibrated or not', 'identify a model of this one')
    return model
