"""Contacts: one force, constant in base axes, that pushes the hand for a while."""

import numpy as np

from ...effects import EXTERNAL_CONTACT
from .disturbance import Cause
from .interval import Kind

NAME = EXTERNAL_CONTACT.name
# The same on another link than the hand: torques are all that is told of it.
ELSEWHERE = 'external_contact_elsewhere'
FORCE = 30.0               # [N] what a person or a touched object does
# A push: at least so long [s], at most this share of a recording, first looked for so close [s].
SHORTEST, LONGEST, CELL = 0.2, 0.5, 0.1
LEAST_SIGMAS = 3.0


def contact(robot, residual):
    """Return the Cause: force (3,) [N] in base axes at the load frame's origin."""
    jacobians = np.array([robot.hand_jacobian(q) for q in residual.x.q])
    # What pushes the hand the drives must hold against.
    columns = residual.all_reported(-FORCE * np.swapaxes(jacobians, 1, 2))
    return Cause(Kind(NAME, columns, np.full(3, FORCE), CELL, SHORTEST, LONGEST, False), _possible)


def _possible(force, covariance, owner):
    """Tell whether there is a force at all."""
    return float(force @ np.linalg.solve(covariance, force)) > LEAST_SIGMAS ** 2


def contact_parameters(disturbance):
    """Return {name: (mean, std, unit)} of the force and its size."""
    force, covariance = disturbance.theta, disturbance.covariance
    std, size = np.sqrt(np.diag(covariance)), np.linalg.norm(force)
    own = {name: (force[k], std[k], unit)
           for k, (name, unit) in enumerate(EXTERNAL_CONTACT.parameters)}
    return own | {'force': (size, np.sqrt(force @ covariance @ force) / size, 'N')}


def torque_parameters(disturbance, joints):
    """Return {name: (mean, std, unit)} of what a push elsewhere does to joints (names)."""
    std = np.sqrt(np.diag(disturbance.covariance))
    return {f'torque ({joint})': (disturbance.theta[j], std[j], 'Nm')
            for j, joint in enumerate(joints)}
