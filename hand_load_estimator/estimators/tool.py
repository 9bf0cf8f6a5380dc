"""A known tool on the hand: taken off the torque, with what is not known of it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..files.configuration import read_yaml, Section
from ..files.load_file import parse_load, placed, says_none
from ..load import products_jacobian_of_message


@dataclass(frozen=True)
class Tool:
    """
    A tool in the load frame.

    products (10,); root (10, k): root @ root.T is the covariance of the products.
    """

    products: np.ndarray
    root: np.ndarray

    @property
    def mass(self):
        """Mass [kg]."""
        return float(self.products[0])

    def beside(self, belief, counted, light):
        """
        Return a Belief of what is held beside the tool, which is known no better than the tool.

        counted: whether the doubt about the tool is in it; what a network or a calibration makes
        of variances was learned without tools. light [kg]: a lighter load's place is as doubtful
        as that of one of this mass.
        """
        if not self.root.size:
            return belief
        mean = belief.mean.copy()
        mean[0] = max(mean[0], light)
        root = np.linalg.solve(products_jacobian_of_message(mean), self.root)
        if not counted:
            return replace(belief, covariance=belief.covariance + root @ root.T)
        own = np.maximum(belief.covariance.diagonal(), 1e-300)
        wider = np.sqrt(np.maximum((root ** 2).sum(axis=1) / own, 1.0))
        return replace(belief, covariance=belief.covariance * np.outer(wider, wider))


def read_tool(path):
    """
    Return the Tool of a load file, or None where it says `none`; raises ConfigurationError.

    Beside mass, com and inertia the file may state `std`: {mass [kg], com: [x, y, z] [m],
    inertia: [ixx, ixy, ixz, iyy, iyz, izz] [kg m^2]}, zero where it does not.
    """
    if says_none(path):
        return None
    section = Section(read_yaml(Path(path)), path)
    std = _std(section.section('std')) if section.has('std') else np.zeros(10)
    load = placed(*parse_load(section), path)
    root = products_jacobian_of_message(load.to_message()) * std
    return Tool(load.to_products(), root[:, std > 0.0])


def _std(section):
    mass = section.number('mass', 0.0, 1000.0) if section.has('mass') else 0.0
    com = section.vector('com', 3, 0.0, 5.0) if section.has('com') else np.zeros(3)
    inertia = section.vector('inertia', 6, 0.0) if section.has('inertia') else np.zeros(6)
    section.refuse_unknown()
    return np.concatenate([[mass], com, inertia])


class ToolFollower:
    """
    A ModelFollower of an arm with a Tool: differences are what the workpiece makes.

    What is not known of the tool stands ahead of the other uncertainties.
    """

    def __init__(self, follower, tool):
        self._follower, self._tool = follower, tool
        # The file's word on the tool is taken in full.
        self._scale = np.concatenate([np.ones(tool.root.shape[1]), follower.column_scale])

    @property
    def uncertainties(self):
        """Number of model columns."""
        return self._follower.uncertainties + self._tool.root.shape[1]

    def restart(self):
        """Forget the path, as after a gap in the data."""
        self._follower.restart()

    def another_load(self):
        """Take the load for another one."""
        self._follower.another_load()

    def carry(self, belief, method):
        """Take a Method's Belief of what is held beside the tool."""
        self._follower.carry(belief, method, self._tool.products)

    def update(self, sample):
        """Return the Prediction at a MotionSample."""
        seen = self._follower.update(sample)
        columns = seen.load_columns
        # Ahead of the others: the last ones are what drifts from run to run.
        return replace(seen, difference=seen.difference - columns @ self._tool.products,
                       model_columns=np.hstack([columns @ self._tool.root, seen.model_columns]),
                       column_scale=self._scale)
