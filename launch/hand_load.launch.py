"""Start estimator and controller for an arm, and the simulator where there is no arm."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

PACKAGE = 'hand_load_estimator'

RECORDED = ('joint_states', 'joint_temperatures', 'estimator/load', 'estimator/load_variance',
            'estimator/load_covariance', 'estimator/status', 'estimator/residual_torque',
            'controller/motion_limits', 'controller/collision_thresholds',
            'controller/collision')


def _argument(name, default, description, choices=None):
    return DeclareLaunchArgument(name, default_value=default, description=description,
                                 choices=choices)


def _switch(name, default, description):
    return _argument(name, default, description, ['true', 'false'])


def _params_file(name):
    default = PathJoinSubstitution([FindPackageShare(PACKAGE), 'config', f'{name}.yaml'])
    return _argument(f'{name}_params', default, f'parameter file of the {name}')


def _node(name, condition=None, **fixed):
    """Return a Node action; the parameters given here win over the file's."""
    return Node(
        package=PACKAGE, executable=f'{name}_node', name=name,
        namespace=LaunchConfiguration('namespace'), output='screen', condition=condition,
        parameters=[ParameterFile(LaunchConfiguration(f'{name}_params'), allow_substs=True),
                    {'robot': ParameterValue(LaunchConfiguration('robot'), value_type=str),
                     **fixed}])


def _nodes_with_model(context):
    """Return estimator and controller; without the argument `model` their files' one holds."""
    fixed = {'use_sim_time': ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool)}
    model = LaunchConfiguration('model').perform(context)
    if model:
        fixed['model'] = ParameterValue(model, value_type=str)
    return [_node('estimator', **fixed),
            _node('controller', IfCondition(LaunchConfiguration('control')), **fixed)]


def generate_launch_description():
    """Return the launch description; `ros2 launch ... --show-args` lists the arguments."""
    return LaunchDescription([
        _argument('robot', 'ur10e', 'robot file: a path, or the short name of a shipped one'),
        _argument('model', '', 'torque model file: a path, or the short name of a shipped one; '
                  'empty: as the parameter files say'),
        _argument('namespace', '', 'namespace of all nodes and topics'),
        _switch('simulate', 'false', 'start the simulator in place of an arm: only where no arm '
                'and no driver of one is on the same ROS domain'),
        # With it unless told otherwise: a node that waits for a /clock of nobody does nothing.
        _switch('use_sim_time', LaunchConfiguration('simulate'), 'time comes from /clock'),
        _switch('control', 'false', 'start the controller, which moves the arm after '
                'controller/start between the waypoints of controller_params'),
        _switch('record', 'false', 'record the topics of the interface to a rosbag2 (MCAP)'),
        *(_params_file(name) for name in ('simulator', 'estimator', 'controller')),
        _node('simulator', IfCondition(LaunchConfiguration('simulate'))),
        OpaqueFunction(function=_nodes_with_model),
        ExecuteProcess(
            cmd=['ros2', 'bag', 'record', '-s', 'mcap', *(
                PathJoinSubstitution(['/', LaunchConfiguration('namespace'), topic])
                for topic in RECORDED)],
            output='screen', condition=IfCondition(LaunchConfiguration('record'))),
    ])
