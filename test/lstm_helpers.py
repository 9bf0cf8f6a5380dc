"""Small LSTM networks, their artefacts and pipelines with them."""

import numpy as np
import torch

from hand_load_estimator.estimators.build import determined_std
from hand_load_estimator.estimators.lstm import Lstm
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.learning.artefact import arm_of, read_artefact, write_artefact
from hand_load_estimator.learning.features import feature_count
from hand_load_estimator.learning.interval_factors import LEVELS
from hand_load_estimator.learning.network import LoadNetwork
from hand_load_estimator.torque.model_follower import ModelFollower

HIDDEN = 12
NEUTRAL = np.ones((10, len(LEVELS)))


def network_of(robot, seed=1, size=0.3):
    """Return a double-precision network with heads that say something of that size."""
    torch.manual_seed(seed)
    network = LoadNetwork(feature_count(robot.n), robot.n, HIDDEN).double()
    with torch.no_grad():
        for head in (network.joint_head, network.load_head):
            for value in head.parameters():
                value.normal_(0.0, size)
    return network


def artefact_of(folder, robot, network, calibration=None, **card):
    """Write a network as an artefact and return it as it is read."""
    weights = {k: v.detach().float().numpy() for k, v in network.state_dict().items()}
    write_artefact(folder, weights, NEUTRAL if calibration is None else calibration,
                   {**arm_of(robot), **card})
    return read_artefact(folder, robot)


def rounded(network):
    """Return the network with its weights as the artefact's single precision keeps them."""
    return network.float().double()


def loud_network(folder, robot):
    """Return (network, artefact) of a network that speaks on all outputs."""
    network = rounded(network_of(robot))
    return network, artefact_of(folder, robot, network)


def pipeline_with(model, artefact):
    """Return a Pipeline with method lstm."""
    follower = ModelFollower(model)
    return Pipeline(model, follower, Lstm(model, follower.uncertainties, artefact),
                    determined_std(model.robot))
