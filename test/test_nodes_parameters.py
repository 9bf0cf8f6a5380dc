"""Parameter tables: YAML, descriptors, refusals agree; a wrong value ends with a sentence."""

from importlib import import_module
from pathlib import Path
import shutil

import pytest
import yaml
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter as RclpyParameter
from ros_helpers import ROOT

from hand_load_estimator.nodes.parameters import Parameter, markdown_table

NODES = ('simulator', 'estimator', 'controller')


def table_of(node):
    """Return the parameter table of a node."""
    module = import_module(f'hand_load_estimator.nodes.{node}_parameters')
    return getattr(module, f'{node.upper()}_PARAMETERS')


def flat(content, prefix=''):
    """Yield dotted names and values of nested mappings."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from flat(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value


@pytest.mark.parametrize('node', NODES)
def test_yaml_holds_exactly_the_table_with_its_defaults(node):
    path = ROOT / 'config' / f'{node}.yaml'
    content = yaml.safe_load(path.read_text())
    values = dict(flat(content[f'/**/{node}']['ros__parameters']))
    rows = {row.name: row for row in table_of(node)}
    assert set(values) == set(rows)
    for name, value in values.items():
        told = rows[name].convert(value)
        assert rows[name].todo or told == rows[name].default, name
        assert isinstance(value, list) or type(value) is type(rows[name].default), name


@pytest.mark.parametrize('node', NODES)
def test_every_value_in_yaml_is_commented(node):
    lines = (ROOT / 'config' / f'{node}.yaml').read_text().splitlines()
    body = lines[lines.index('  ros__parameters:') + 1:]
    wanting = [line for line in body if line.strip() and not line.rstrip().endswith(':')
               and '#' not in line]
    assert not wanting


@pytest.mark.parametrize('node', NODES)
def test_every_row_is_described_and_its_default_allowed(node):
    for row in table_of(node):
        assert row.description and row.convert(row.default) == row.default
        assert f'`{row.name}`' in markdown_table(table_of(node))


@pytest.mark.parametrize('node', NODES)
def test_readme_shows_the_table(node):
    readme = ROOT / 'README.md'
    assert markdown_table(table_of(node)) in readme.read_text(), \
        f'put markdown_table({node.upper()}_PARAMETERS) into README.md'


@pytest.mark.parametrize('value, accepted', [
    (1.0, 1.0), (1, 1.0), (0.5, None), (2.5, None), (float('nan'), None), (True, None),
    ('1.0', None), ([1.0], None)])
def test_number_in_range(value, accepted):
    row = Parameter('x', 1.0, 'a number', low=1.0, high=2.0)
    if accepted is None:
        with pytest.raises(ValueError):
            row.convert(value)
    else:
        assert row.convert(value) == accepted and type(row.convert(value)) is float


def test_array_has_its_size_and_every_element_its_range():
    row = Parameter('x', (0.0, 0.0), 'two numbers', low=-1.0, size=2)
    assert row.convert([1, 2]) == (1.0, 2.0)
    for wrong in ([1.0], [], [1.0, -2.0], 1.0, 'ab', ['a', 'b']):
        with pytest.raises(ValueError):
            row.convert(wrong)


@pytest.mark.parametrize('argument, said', [
    ('robot:=nowhere.yaml', 'nowhere.yaml'), ('method:=magic', 'lstm or bayes'),
    ('publish_rate:=0.0', '1 to 50'), ('publish_rate:=fast', 'double'),
    ('joint_states_depth:=1.5', 'integer')])
def test_wrong_value_at_start_ends_with_status_2_and_one_sentence(start, argument, said):
    node = start('estimator', '--ros-args', '-p', argument)
    assert node.wait(30.0) == 2
    assert said in node.output and node.output.count('\n') == 1, node.output
    assert 'Traceback' not in node.output


@pytest.mark.parametrize('node', ['estimator', 'controller'])
def test_a_robot_without_a_shipped_model_is_told_to_give_one(start, node):
    """`ur10e_current: is neither a path nor a shipped file` named neither parameter nor model."""
    process = start(node, '--ros-args', '--params-file', ROOT / 'config' / f'{node}.yaml', '-p',
                    'robot:=ur10e_current')
    assert process.wait(30.0) == 2
    assert process.output == ('error: parameter model: none is shipped for robot ur10e_current; '
                              'give model:=FILE, which `hand_load identify` makes from its '
                              'recordings\n')


@pytest.mark.parametrize('node', ['estimator', 'controller'])
def test_a_wrong_robot_file_is_told_before_its_model_is_missed(start, node, tmp_path):
    # A copy without its URDF.
    wrong = Path(shutil.copy(ROOT / 'config' / 'robots' / 'ur10e.yaml', tmp_path / 'my_arm.yaml'))
    process = start(node, '--ros-args', '--params-file', ROOT / 'config' / f'{node}.yaml', '-p',
                    f'robot:={wrong}')
    assert process.wait(30.0) == 2
    assert f'{wrong}: urdf' in process.output, process.output
    assert 'parameter model' not in process.output and process.output.count('\n') == 1


def test_waypoints_are_nobodys_but_the_users(start):
    process = start('controller', '--ros-args', '-p', 'robot:=ur10e')
    assert process.wait(30.0) == 2
    assert process.output.startswith('error: node controller: parameter home: must be given')
    assert 'config/controller.yaml' in process.output


def test_unreadable_parameter_file_ends_with_status_2(start, tmp_path):
    wrong = tmp_path / 'wrong.yaml'
    wrong.write_text('a: [1, 2\n')
    node = start('simulator', '--ros-args', '--params-file', wrong)
    assert node.wait(30.0) == 2
    assert str(wrong) in node.output and 'Traceback' not in node.output


def test_running_node_describes_accepts_and_refuses(start, listener):
    """`ros2 param describe` and `ros2 param set` meet the table."""
    start('simulator', '--ros-args', '-p', 'robot:=ur10e', '-p', 'ratee:=3.0')
    described = listener.call(DescribeParameters, '/simulator/describe_parameters',
                              DescribeParameters.Request(names=['real_time_factor', 'rate']),
                              timeout=30.0).descriptors
    assert 'simulated seconds' in described[0].description and not described[0].read_only
    assert described[0].floating_point_range[0].to_value == 100.0
    assert described[1].read_only

    def set_one(name, value):
        message = RclpyParameter(name, value=value).to_parameter_msg()
        return listener.call(SetParameters, '/simulator/set_parameters',
                             SetParameters.Request(parameters=[message])).results[0]

    assert set_one('real_time_factor', 2).successful
    assert set_one('load.com', [0.1, 0.2, 0.3]).successful
    for name, value in (('real_time_factor', 1000.0), ('load.com', [0.1]), ('rate', 100.0),
                        ('load.mass', -1.0), ('load.mass', 'heavy')):
        result = set_one(name, value)
        assert not result.successful and result.reason, name


def test_misspelled_parameter_is_told(start, listener):
    node = start('simulator', '--ros-args', '-p', 'plant_sed:=3')
    listener.until(lambda: 'plant_seed' in node.output, 'a hint')


def test_a_parameter_file_for_another_node_is_told(start, listener, tmp_path):
    """Renamed, a node had ignored its file without a word."""
    file = tmp_path / 'mine.yaml'
    file.write_text('/**/simulator:\n  ros__parameters:\n    plant_seed: 3\n')
    node = start('simulator', '--ros-args', '--params-file', file, '-r', '__node:=left_arm')
    listener.until(lambda: 'has no parameters for /left_arm' in node.output, 'a warning')
    other = start('simulator', '--ros-args', '--params-file', file)
    listener.until(lambda: '/joint_states' in dict(listener.node.get_topic_names_and_types()),
                   'a start')
    assert 'has no parameters' not in other.output


def test_a_switch_of_ros_s_own_given_as_text_ends_with_status_2(start, tmp_path):
    file = tmp_path / 'mine.yaml'
    file.write_text('/**:\n  ros__parameters:\n    use_sim_time: "true"\n')
    node = start('estimator', '--ros-args', '--params-file', file)
    assert node.wait(30.0) == 2
    assert 'use_sim_time' in node.output and 'Traceback' not in node.output
