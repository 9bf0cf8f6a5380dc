"""Parameter table of the simulator node."""

from .parameters import Parameter

SIMULATOR_PARAMETERS = (
    Parameter('robot', 'ur10e', 'robot file: a path, or the short name of a shipped one'),
    Parameter('plant_seed', 1, 'draws how the simulated arm differs from its robot file',
              low=0, high=2**31),
    Parameter('start_temperature', 25.0, 'temperature of all joints at the start', 'degC',
              low=-20.0, high=80.0),
    Parameter('ambient_temperature', 25.0, 'temperature of the air around the arm', 'degC',
              low=-20.0, high=60.0),
    Parameter('hidden_effects', '', 'effects file: what the arm has beyond the default plant; '
              'empty: nothing'),
    Parameter('rate', 500.0, 'rate of joint_states', 'Hz', low=30.0, high=1000.0),
    Parameter('real_time_factor', 1.0, 'simulated seconds per second', low=0.01, high=100.0,
              read_only=False),
    Parameter('load.mass', 3.0, 'mass of the load taken at the next attach', 'kg', low=0.0,
              high=1000.0, read_only=False),
    Parameter('load.com', (0.02, -0.01, 0.08), 'its centre of mass in the load frame', 'm',
              low=-5.0, high=5.0, size=3, read_only=False),
    Parameter('load.inertia', (0.02, 0.0, 0.0, 0.02, 0.0, 0.015), 'its inertia about the centre '
              'of mass: ixx ixy ixz iyy iyz izz', 'kg m^2', low=-100.0, high=100.0, size=6,
              read_only=False),
)
