"""Load changes: for a time another load hangs on the hand than a recording declares."""

import numpy as np

from ...effects import LOAD_CHANGE
from ...load import message_from_products, products_jacobian_of_message
from ...torque.shown_links import shown_links
from .disturbance import Cause
from .interval import Kind

NAME = LOAD_CHANGE.name
# Its distance [m] from the load frame and its radius of gyration squared [m^2], as a scale.
REACH, GYRATION = 0.15, 0.02
# A load is held at least so long [s]; moments first looked for are so close [s].
SHORTEST, CELL, LONGEST = 1.0, 0.25, 0.95
# No hand holds more than this times its rated mass.
OVERLOAD = 1.5
SIGMAS = 2.0
# A centre of mass known no better than this [m] is not told.
LOOSE = 0.1


def load_change(robot, residual, declared):
    """
    Return the Cause: a change of the load's ten products, against `declared` loads.

    declared: LoadParameters per recording. No load gets lighter than nothing.
    """
    x, rated = residual.x, robot.rated_load.mass
    scale = rated * np.array([1.0, *[REACH] * 3, *[REACH ** 2 + GYRATION] * 6])
    columns = residual.all_reported(robot.load_columns(shown_links(robot, x)))
    kind = Kind(NAME, columns * scale, scale, CELL, SHORTEST, LONGEST, True)

    def possible(products, covariance, owner):
        mass, std = products[0], np.sqrt(covariance[0, 0])
        held = declared[owner].mass
        return abs(mass) > SIGMAS * std and mass + held > -SIGMAS * std \
            and mass + held < OVERLOAD * rated + SIGMAS * std
    return Cause(kind, possible)


def load_parameters(disturbance):
    """Return {name: (mean, std, unit)}: change of mass, and where its centre is, if known."""
    message = message_from_products(disturbance.theta)
    jacobian = np.linalg.inv(products_jacobian_of_message(message))
    std = np.sqrt(np.diag(jacobian @ disturbance.covariance @ jacobian.T))
    told = LOAD_CHANGE.parameters[:None if std[1:4].max() < LOOSE else 1]
    return {name: (message[k], std[k], unit) for k, (name, unit) in enumerate(told)}


def looks_loaded(mass, declared):
    """Return the sentence on a recording that carries another mass [kg] than is declared."""
    said = 'none' if declared == 0.0 else f'{declared:.2g} kg'
    return (f'looks loaded with about {mass:.2g} kg, declared: {said}; give the load that it '
            'carries (--load, or load.yaml in the recording)')
