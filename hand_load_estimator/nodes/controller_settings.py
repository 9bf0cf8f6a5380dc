"""The torque model and the settings of a cycle that the controller's parameters ask for."""

from dataclasses import replace

import numpy as np

from ..control.acceleration_limits import PlanSettings
from ..control.collision_threshold import ThresholdSettings
from ..control.fallback import FallbackSettings
from ..control.supervisor import CycleSettings
from ..errors import ConfigurationError
from ..robot import load_robot
from ..torque.model_of_robot import model_of_robot
from .model_choice import robot_and_model


def model_from_parameters(values):
    """Return the TorqueModel the parameters ask for; raises ConfigurationError."""
    path, model_file = robot_and_model(values)
    robot = load_robot(path)
    # The limits that hold are today's robot file's, not those of the day of identification.
    return replace(model_of_robot(model_file, robot), robot=robot)


def settings_from_parameters(values, robot):
    """Return the CycleSettings; raises ConfigurationError for waypoints the arm cannot take."""
    waypoints = {name: np.array(getattr(values, name)) for name in ('home', 'pick', 'place')}
    for name, q in waypoints.items():
        if len(q) != robot.n:
            raise ConfigurationError(f'parameter {name}', 'does not fit the robot', q.tolist(),
                                     f'{robot.n} joint positions, of {", ".join(robot.joints)}')
        if np.any(q < robot.limits.lower) or np.any(q > robot.limits.upper):
            raise ConfigurationError(f'parameter {name}', 'is outside the joint limits',
                                     q.tolist(), f'{robot.limits.lower.tolist()} to '
                                     f'{robot.limits.upper.tolist()} rad')
    return CycleSettings(
        waypoints, values.cycles, values.dwell, values.home_dwell,
        PlanSettings(values.sigma, values.acceleration_rise_time, values.speed_scale),
        FallbackSettings(values.estimate_timeout, values.relax_time),
        ThresholdSettings(margin=values.collision_margin, sigma=values.sigma,
                          debounce=values.collision_debounce))
