"""Which robot and model files the parameters `robot` and `model` of a node stand for."""

from ..errors import ConfigurationError
from ..files.shared_files import find_shared
from ..robot import load_robot


def robot_and_model(values):
    """Return (robot file, model file) as Paths; raises ConfigurationError."""
    robot = find_shared(values.robot, 'robots')
    if values.model:
        return robot, find_shared(values.model, 'models')
    try:
        return robot, find_shared(robot.stem, 'models')
    except ConfigurationError:
        load_robot(robot)  # What is wrong with it is the nearer fault.
        raise ConfigurationError(
            'parameter model', f'none is shipped for robot {robot.stem}',
            todo='give model:=FILE, which `hand_load identify` makes from its recordings'
        ) from None
