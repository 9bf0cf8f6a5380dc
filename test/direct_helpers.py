"""Small direct networks, their artefacts and pipelines with them."""

from core_helpers import warm
import numpy as np
import torch

from hand_load_estimator.estimators.build import determined_std
from hand_load_estimator.estimators.direct import Direct
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.learning.artefact import arm_of
from hand_load_estimator.learning.direct_artefact import (read_direct_artefact,
                                                          write_direct_artefact)
from hand_load_estimator.learning.direct_design import Design, design_for
from hand_load_estimator.learning.direct_network import build_network, inputs_of
from hand_load_estimator.learning.stated_factors import RANGES
from hand_load_estimator.torque.model_follower import ModelFollower


def design_of(robot, network='gru', **changes):
    """Return a small Design."""
    content = {**vars(design_for(robot, network)), 'hidden': 12, 'copies': 5, **changes}
    return Design(**content)


def network_of(robot, design, seed=1, size=0.3):
    """Return a network whose heads say something of that size."""
    torch.manual_seed(seed)
    network = build_network(robot, design)
    with torch.no_grad():
        for name, value in network.named_parameters():
            if 'head' in name:
                value.normal_(0.0, size)
    return network.eval()


def inputs(robot, joints=None, count=40, seed=0):
    """Return x (2, count, 5 k + 1) of random motion."""
    rng = np.random.default_rng(seed)
    parts = [torch.tensor(rng.normal(size=(2, count, robot.n)), dtype=torch.float32)
             for _ in range(5)]
    picked = list(range(robot.n)) if joints is None else joints
    return inputs_of(robot, picked, parts[:3], 10.0 * parts[3], 10.0 * parts[4])


def artefact_of(folder, robot, network, factor=1.0):
    """Write a network as an artefact and return it as it is read."""
    shape = (len(network.design.parameters), RANGES)
    card = {**arm_of(robot), 'network': network.design.network,
            'recipe': {'design': vars(network.design)}}
    write_direct_artefact(folder, network, np.tile(np.arange(RANGES), (shape[0], 1)),
                          np.full(shape, factor), card)
    return read_direct_artefact(folder, robot, network.design.network)


def pipeline_with(model, artefact):
    """Return a Pipeline with a direct method."""
    follower = ModelFollower(model)
    return warm(Pipeline(model, follower, Direct(model, follower.uncertainties, artefact),
                         determined_std(model.robot)))
