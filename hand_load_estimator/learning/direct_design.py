"""
Which direct network: what it reads, what it answers and how large it is (E1.3 to E1.6, E6).

Direct networks go from motion and torque difference to the load without a regression between, as
the reference's worked examples do. Nothing here needs torch, so that names can be listed cheaply.
"""

from dataclasses import dataclass

from ..errors import ConfigurationError
from ..load import MESSAGE_ORDER

# name -> what it is, for help and card
NETWORKS = {
    'lstm_direct': 'LSTM (E1.3, eq. 2-7)',
    'gru': 'gated recurrent units (E1.3)',
    'elman': 'Elman network (E1.3)',
    'jordan': 'Jordan network (E1.3)',
    'feedforward': 'feed-forward network on windows of a fixed length (E1.4)',
    'two_network': 'LSTM for the load and LSTM for the torque error that corrects it (E1.6)',
    'dropout': 'LSTM, judged by randomly thinned copies of itself (E6.2)'}

# What may be chosen of a network's size (E1.3, E1.4): least and most.
SIZES = {'hidden': (1, 1024), 'layers': (1, 8), 'window': (1, 500)}


@dataclass(frozen=True)
class Design:
    """
    What decides a direct network's shape.

    network: key of NETWORKS; joints: names of those it reads (E1.5); parameters: names, of
    MESSAGE_ORDER, of those it answers (E1.5); hidden units per layer; layers: recurrent ones, or
    those behind the window; head_layers: 0 or 1 between those and the answer; window: samples a
    feed-forward network reads at once; thinned: share of units that dropout leaves out; copies:
    thinned networks that judge.
    """

    network: str
    joints: tuple
    parameters: tuple = MESSAGE_ORDER
    hidden: int = 96
    layers: int = 1
    window: int = 25
    thinned: float = 0.1
    copies: int = 16
    head_layers: int = 0

    @property
    def picked(self):
        """Places of the parameters in message order."""
        return [MESSAGE_ORDER.index(name) for name in self.parameters]

    @property
    def learnt(self):
        """Places of what the network answers: of the parameters, and of the mass for a centre."""
        place = set(self.parameters) & set(MESSAGE_ORDER[1:4])
        return sorted({*self.picked, 0} if place else self.picked)

    @property
    def answers(self):
        """How many numbers the network answers: mean and deviation of what it learns."""
        return 2 * len(self.learnt)


def design_for(robot, network, joints=None, parameters=None, **sizes):
    """
    Return the Design of a network for a robot; raises ConfigurationError.

    joints, parameters: names, or None for all; sizes: of SIZES, those that are not the default.
    """
    for name, value in sizes.items():
        least, most = SIZES[name]
        if not least <= value <= most:
            raise ConfigurationError(f'--{name}', 'is not usable', value, f'{least} to {most}')
    if network not in NETWORKS:
        raise ConfigurationError('--network', 'is not known', network, ', '.join(NETWORKS))
    # What recurrent layers gather are sums: a load is a quotient of those, which no sum gives.
    # A Jordan network's answer is what it remembers, with nothing between.
    return Design(network, _subset('--joints', joints, robot.joints),
                  _subset('--parameters', parameters, MESSAGE_ORDER),
                  head_layers=0 if network in ('feedforward', 'jordan') else 1, **sizes)


def _subset(where, chosen, allowed):
    if chosen is None:
        return tuple(allowed)
    wrong = [name for name in chosen if name not in allowed]
    if wrong or not chosen:
        raise ConfigurationError(where, 'names none of this robot', ', '.join(wrong),
                                 ', '.join(allowed))
    # In the robot's order, so that a different order of writing is not a different network.
    return tuple(name for name in allowed if name in chosen)
