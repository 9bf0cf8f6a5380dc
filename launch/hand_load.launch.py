"""Start estimator and controller for an arm, and the simulator where there is no arm."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'hand_load_estimator'

# What is measured, commanded and answered; in the namespace but for the last.
RECORDED = ('joint_states', 'joint_temperatures', 'dynamic_joint_states',
            'joint_trajectory_controller/joint_trajectory', 'simulator/true_load',
            'estimator/load', 'estimator/load_variance', 'estimator/load_covariance',
            'estimator/status', 'estimator/residual_torque', 'estimator/known_load',
            'estimator/suggested_motion', 'controller/motion_limits',
            'controller/collision_thresholds', 'controller/collision', 'controller/phase',
            '/diagnostics')


def _argument(name, default, description, choices=None):
    return DeclareLaunchArgument(name, default_value=default, description=description,
                                 choices=choices)


def _switch(name, default, description):
    return _argument(name, default, description, ['true', 'false'])


def _params_file(name):
    default = PathJoinSubstitution([FindPackageShare(PACKAGE), 'config', f'{name}.yaml'])
    return _argument(f'{name}_params', default, f'parameter file of the {name}')


def _node(name, *given):
    """Return a Node action; parameters {name: value} that are given win over the file's."""
    return Node(
        package=PACKAGE, executable=f'{name}_node', name=name,
        namespace=LaunchConfiguration('namespace'), output='screen',
        parameters=[ParameterFile(LaunchConfiguration(f'{name}_params'), allow_substs=True),
                    *filter(None, given)])


def _nodes(context):
    """Return the nodes asked for; what no argument says, their parameter files say."""
    simulated = LaunchConfiguration('simulate').perform(context) == 'true'
    robot = _text('robot', LaunchConfiguration('robot').perform(context))
    model = _text('model', LaunchConfiguration('model').perform(context))
    sim_time = LaunchConfiguration('use_sim_time').perform(context)
    # A node that waits for a /clock of nobody does nothing.
    clock = {'use_sim_time': sim_time != 'false'} if sim_time or simulated else {}
    nodes = [_node('estimator', robot, model, clock)]
    if simulated:
        nodes.append(_node('simulator', robot))
    if LaunchConfiguration('control').perform(context) == 'true':
        nodes.append(_node('controller', robot, model, clock))
    return nodes


def _text(name, value):
    return {name: ParameterValue(value, value_type=str)} if value else {}


def generate_launch_description():
    """Return the launch description; `ros2 launch ... --show-args` lists the arguments."""
    return LaunchDescription([
        _argument('robot', '', 'robot file: a path, or the short name of a shipped one; '
                  'empty: as the parameter files say'),
        _argument('model', '', 'torque model file: a path, or the short name of a shipped one; '
                  'empty: as the parameter files say'),
        _argument('namespace', '', 'namespace of all nodes and topics'),
        _switch('simulate', 'false', 'start the simulator in place of an arm: only where no arm '
                'and no driver of one is on the same ROS domain'),
        _argument('use_sim_time', '', 'time comes from /clock; empty: as the parameter files say, '
                  'and true with simulate', ['true', 'false', '']),
        _switch('control', 'false', 'start the controller, which moves the arm after '
                'controller/start between the waypoints of controller_params'),
        _switch('record', 'false', 'record what is measured, commanded and answered to a rosbag2 '
                '(MCAP)'),
        *(_params_file(name) for name in ('simulator', 'estimator', 'controller')),
        OpaqueFunction(function=_nodes),
        ExecuteProcess(
            cmd=['ros2', 'bag', 'record', '-s', 'mcap', *(
                PathJoinSubstitution(['/', LaunchConfiguration('namespace'), topic])
                for topic in RECORDED)],
            output='screen', condition=IfCondition(LaunchConfiguration('record'))),
    ])
