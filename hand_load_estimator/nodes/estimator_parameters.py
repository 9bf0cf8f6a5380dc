"""Parameter table of the estimator node."""

from ..estimators.registry import DEFAULT, METHODS
from .parameters import Parameter

ESTIMATOR_PARAMETERS = (
    Parameter('robot', 'ur10e', 'robot file: a path, or the short name of a shipped one'),
    Parameter('model', '', 'torque model file: a path or the short name of a shipped one; empty: '
              'the shipped model named like the robot; a change is taken by ~/reload_model',
              read_only=False),
    Parameter('method', DEFAULT, 'estimator; a robot without a learned artefact of that method '
              'uses bayes', choices=tuple(METHODS)),
    Parameter('learned', '', 'folder of the learned artefact; empty: the shipped one for the '
              'method and the robot\'s joints and effort kind, if any'),
    Parameter('publish_rate', 50.0, 'highest rate of the load topics', 'Hz', low=1.0,
              high=1000.0, read_only=False),
    Parameter('marker_rate', 10.0, 'rate of the markers; 0: none', 'Hz', low=0.0, high=100.0,
              read_only=False),
    Parameter('joint_states_depth', 2000, 'joint states kept while the node is busy: at least '
              'one second of them', 'messages', low=10, high=100000),
    Parameter('temperatures_depth', 200, 'temperatures kept while the node is busy: at least one '
              'second of them', 'messages', low=10, high=100000),
)
