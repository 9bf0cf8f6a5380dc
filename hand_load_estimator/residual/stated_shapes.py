"""How well the searched shapes of what was found are known, in the model that is written."""

from dataclasses import replace

import numpy as np


def with_stated_shapes(better, findings):
    """
    Return the better TorqueModel with standard deviations of searched shapes, as Findings say.

    Of a Stribeck velocity, a period, a travel: the covariance is that of the linear parameters,
    with the shapes where they are. A shape whose gain has no maximum has none. The same model
    where nothing is to be stated.
    """
    uses = tuple(_stated(use, better.robot.joints[use.joint], findings) for use in better.uses)
    return better if uses == better.uses else replace(better, uses=uses)


def _stated(use, joint, findings):
    found = next((f for f in findings if f.name == use.name and joint in f.joints
                  and not f.recording), None)
    if found is None:
        return use
    std = {name: told[1] for name in use.told_shape
           for told in [found.parameters.get(name, found.parameters.get(f'{name} ({joint})'))]
           if told is not None and np.isfinite(told[1])}
    return replace(use, shape_std={**use.shape_std, **std})
