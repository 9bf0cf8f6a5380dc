"""Parameter table of the estimator node."""

from ..estimators.registry import DEFAULT, METHODS
from .parameters import Parameter

ESTIMATOR_PARAMETERS = (
    Parameter('robot', 'ur10e', 'robot file: a path, or the short name of a shipped one'),
    Parameter('model', '', 'torque model file: a path or the short name of a shipped one; empty: '
              'the shipped model named like the robot; a change is taken by ~/reload_model',
              read_only=False),
    Parameter('method', DEFAULT, 'estimator; without a learned artefact gp_... ends with a '
              'message, the others become bayes', choices=tuple(METHODS)),
    Parameter('learned', '', 'folder of the learned artefact, or short name of a shipped one; '
              'empty: the shipped one for the method and the robot\'s joints and effort kind '
              '(gp_...: for the model)'),
    Parameter('intervals', '', 'folder of the calibrated intervals (`hand_load calibrate`) of a '
              'method without a network, or short name of shipped ones, which are of simulated '
              'arms; empty: those shipped for this very model, else as the method states them'),
    Parameter('tool', '', 'load file of a known tool, which may state `std`; the estimate is what '
              'is held beside it; empty: none'),
    Parameter('checkpoint', '', 'file in which the estimate survives a restart or kill, written '
              'once a second; empty: none'),
    Parameter('checkpoint_max_age', 3600.0, 'age from which a checkpoint is refused: nobody '
              'knows what the hand did meanwhile', 's', low=1.0, high=1e8),
    Parameter('publish_rate', 50.0, 'highest rate of the load topics; the residual torque '
              'comes with every estimate, 50 times a second at most', 'Hz', low=1.0, high=50.0,
              read_only=False),
    Parameter('marker_rate', 10.0, 'rate of the markers; 0: none', 'Hz', low=0.0, high=100.0,
              read_only=False),
    Parameter('joint_states_depth', 2000, 'joint states kept while the node is busy: at least '
              'one second of them', 'messages', low=10, high=100000),
    Parameter('temperatures_depth', 200, 'temperatures kept while the node is busy: at least one '
              'second of them', 'messages', low=10, high=100000),
)
