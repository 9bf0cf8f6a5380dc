"""Parameter table of the controller node."""

from .parameters import Parameter

_WAYPOINTS = ('give waypoints of your arm and cell; --params-file config/controller.yaml has '
              'those of the shipped UR10e')

CONTROLLER_PARAMETERS = (
    Parameter('robot', 'ur10e', 'robot file: a path, or the short name of a shipped one'),
    Parameter('model', '', 'torque model file: a path or the short name of a shipped one; empty: '
              'the shipped model named like the robot'),
    Parameter('autostart', False, 'begin the cycle without a call of ~/start: the arm moves as '
              'soon as joint states come'),
    Parameter('cycles', 1, 'pick-and-place cycles to run; 0: until stopped', low=0, high=10**6),
    Parameter('home', (0.0,), 'joint positions between cycles', 'rad', low=-20.0, high=20.0,
              todo=_WAYPOINTS),
    Parameter('pick', (0.0,), 'joint positions at which the load is gripped', 'rad', low=-20.0,
              high=20.0, todo=_WAYPOINTS),
    Parameter('place', (0.0,), 'joint positions at which the load is released', 'rad', low=-20.0,
              high=20.0, todo=_WAYPOINTS),
    Parameter('dwell', 1.5, 'time at pick and place, in which the hand grips or releases', 's',
              low=0.0, high=600.0),
    Parameter('home_dwell', 1.0, 'time at home before a cycle', 's', low=0.0, high=600.0),
    Parameter('speed_scale', 0.7, 'share of the robot file\'s max_velocity that moves use',
              low=0.01, high=1.0),
    Parameter('acceleration_rise_time', 0.1, 'time in which an acceleration builds up', 's',
              low=0.02, high=1.0),
    Parameter('sigma', 3.0, 'standard deviations of the load\'s torque added on the safe side',
              low=1.0, high=10.0),
    Parameter('estimate_timeout', 0.5, 'age of the estimate from which the rated load is taken '
              'instead', 's', low=0.05, high=60.0),
    Parameter('relax_time', 0.5, 'time from the rated load\'s limits to the estimate\'s; the '
              'other way is at once', 's', low=0.0, high=60.0),
    Parameter('collision_margin', 6.0, 'part of the collision threshold: times the torque '
              'model\'s noise', low=1.0, high=100.0),
    Parameter('collision_debounce', 3, 'residual torques in a row beyond the threshold that '
              'make a collision; 0.2 s of them do so sooner', 'messages', low=1, high=1000),
    Parameter('rate', 100.0, 'rate of supervision and of the thresholds', 'Hz', low=50.0,
              high=500.0),
    Parameter('joint_states_depth', 2000, 'joint states kept while the node is busy: at least '
              'one second of them', 'messages', low=10, high=100000),
    Parameter('temperatures_depth', 200, 'temperatures kept while the node is busy: at least one '
              'second of them', 'messages', low=10, high=100000),
)
