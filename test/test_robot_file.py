"""Robot files: what is shipped loads, what is wrong is refused with file, key and value."""

import re

import numpy as np
import pinocchio as pin
from plant_helpers import chain, chain_urdf, ROBOTS
import pytest
import yaml

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.configuration import Section
from hand_load_estimator.robot import load_robot, robot_from_content


def content(**changes):
    """Return the content of a four-axis robot file, changed; None removes a key."""
    out = {**chain('z', 'y', 'y', 'x').file.content, **changes}
    return {key: value for key, value in out.items() if value is not None}


def effort(**changes):
    """Return an effort section, changed; None removes a key."""
    out = {'kind': 'motor_current', 'torque_constants': [10.0, -10.0, 8.0, 8.0],
           'torque_constants_std': 0.05, 'includes_configured_load': False, **changes}
    return {key: value for key, value in out.items() if value is not None}


@pytest.mark.parametrize('name', sorted(path.stem for path in ROBOTS.glob('*.yaml')))
def test_shipped_robot_files_load(name):
    robot = load_robot(ROBOTS / f'{name}.yaml')
    assert robot.n == len(robot.joints) == 6
    assert (robot.limits.lower < robot.limits.upper).all()
    assert robot.rated_load.is_physical() and robot.rated_load.mass > 0.0


def test_both_kinds_of_effort_are_shipped():
    kinds = {load_robot(path).effort.kind for path in ROBOTS.glob('*.yaml')}
    assert {'motor_torque', 'motor_current'} <= kinds


@pytest.mark.parametrize('axes', ['zyyx', 'zyzyzyz', 'zyyzyzyz'])
def test_arms_of_any_number_of_axes(axes):
    robot, rng = chain(*axes), np.random.default_rng(1)
    q, v, a = rng.normal(size=(3, len(axes)))
    assert robot.n == len(axes)
    np.testing.assert_allclose(robot.link_regressor(q, v, a) @ robot.nominal_links,
                               robot.rigid_torque(q, v, a), atol=1e-9)


@pytest.mark.parametrize('axes', [('y',), ('z', 'prismatic z')])
def test_fewer_than_three_axes_are_refused(axes):
    """`excite` and `identify` ended in tracebacks; a gantry of three is an arm."""
    with pytest.raises(ConfigurationError, match='joints: are too few.*3 or more'):
        chain(*axes)
    assert chain('prismatic x', 'prismatic y', 'prismatic z').n == 3


def test_a_prismatic_axis_is_an_axis():
    robot = chain('z', 'prismatic z', 'y')
    assert robot.n == 3 and robot.limits.upper[1] == pytest.approx(0.15)


CONTINUOUS = {
    'with limits': lambda urdf: urdf.replace('type="revolute"', 'type="continuous"', 1),
    'limits of effort and speed only': lambda urdf: re.sub(
        r'lower="-2.5" upper="2.5" ', '', urdf.replace('"revolute"', '"continuous"', 1), count=1),
    'single quotes': lambda urdf: urdf.replace('type="revolute"', "type='continuous'", 1),
    'without limits': lambda urdf: re.sub(
        r'<limit[^>]*/>', '', urdf, count=1).replace('"revolute"', '"continuous"', 1)}


@pytest.mark.parametrize('how', CONTINUOUS)
def test_continuous_joints_are_angles(how):
    """XML allows both quotes, and URDF no limit element, for a joint that turns for ever."""
    robot = robot_from_content(content(urdf=CONTINUOUS[how](content()['urdf'])), 'test')
    q = np.array([0.7, -0.3, 0.5, 0.2])
    plain, zero = robot_from_content(content(), 'test'), np.zeros(4)
    np.testing.assert_allclose(robot.rigid_torque(q, zero, zero),
                               plain.rigid_torque(q, zero, zero), atol=1e-12)
    assert robot.limits.lower[0] < robot.limits.upper[0]


def test_extra_joints_are_locked_and_keep_their_mass():
    finger = ('<link name="finger"><inertial><mass value="0.4"/><origin xyz="0 0 0.05"/>'
              '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial>'
              '</link><joint name="grip" type="prismatic"><parent link="l3"/>'
              '<child link="finger"/><axis xyz="1 0 0"/>'
              '<limit lower="0" upper="0.1" effort="5" velocity="1"/></joint></robot>')
    urdf = chain_urdf('zyyx').replace('</robot>', finger)
    robot, bare = robot_from_content(content(urdf=urdf), 'test'), chain(*'zyyx')
    assert robot.joints == bare.joints
    masses = [r.nominal_links[30] for r in (robot, bare)]
    assert masses[0] - masses[1] == pytest.approx(0.4)
    full = pin.buildModelFromXML(urdf)
    q, zero = np.array([0.3, -0.4, 0.6, 0.1, 0.0]), np.zeros(5)
    full.gravity.linear = np.array([0.0, 0.0, -9.81])
    index = [full.joints[full.getJointId(j)].idx_q for j in robot.joints]
    at = np.zeros(5)
    at[index] = q[:4]
    np.testing.assert_allclose(robot.rigid_torque(q[:4], zero[:4], zero[:4]),
                               pin.rnea(full, full.createData(), at, zero, zero)[index],
                               atol=1e-9)


WRONG = {
    'name missing': (content(name=None), 'name', 'missing'),
    'name a number': (content(name=7), 'name', '7'),
    'joints missing': (content(joints=None), 'joints', 'missing'),
    'joints twice': (content(joints=['j0', 'j0', 'j1', 'j2']), 'joints', 'j0'),
    'joints a text': (content(joints='j0 j1'), 'joints', 'j0 j1'),
    'joint unknown': (content(joints=['j0', 'j1', 'j2', 'j9']), 'joints', 'j9'),
    'joints in wrong order': (content(joints=['j1', 'j0', 'j2', 'j3']), 'joints', 'order'),
    'urdf not there': (content(urdf='nowhere.urdf'), 'urdf', 'nowhere.urdf'),
    'urdf no XML': (content(urdf='<robot'), 'urdf', 'URDF'),
    'load_frame unknown': (content(load_frame='hand'), 'load_frame', 'hand'),
    'load_frame inside the chain': (content(load_frame='l1'), 'load_frame', 'l1'),
    'gravity of two': (content(gravity=[0.0, -9.81]), 'gravity', '-9.81'),
    'gravity in g': (content(gravity=[0.0, 0.0, -0.5]), 'gravity', '-0.5'),
    'gravity NaN': (content(gravity=[0.0, 0.0, float('nan')]), 'gravity', 'nan'),
    'temperature in kelvin': (content(reference_temperature=298.0), 'reference_temperature',
                              '298'),
    'temperature a flag': (content(reference_temperature=True), 'reference_temperature', 'True'),
    'rated load without mass': (content(rated_load={'com': [0, 0, 0]}), 'mass', 'missing'),
    'rated load of nothing': (content(rated_load={'mass': 0.0}), 'rated_load', '0.0'),
    'rated load somewhere': (content(rated_load={'mass': 1.0}), 'rated_load', 'com'),
    'configured load somewhere': (content(effort=effort(
        includes_configured_load=True, configured_load={'mass': 1.0})), 'configured_load',
        'com'),
    'rated load impossible': (content(rated_load={
        'mass': 1.0, 'inertia': [0.01, 0, 0, 0.01, 0, 0.05]}), 'inertia', '0.05'),
    'effort missing': (content(effort=None), 'effort', 'missing'),
    'effort a text': (content(effort='torque'), 'effort', 'torque'),
    'effort kind unknown': (content(effort=effort(kind='current')), 'kind', 'motor_current'),
    'currents without constants': (content(effort=effort(torque_constants=None)),
                                   'torque_constants', 'missing'),
    'constants of three': (content(effort=effort(torque_constants=[1.0, 1.0, 1.0])),
                           'torque_constants', '4 numbers'),
    'a constant of zero': (content(effort=effort(torque_constants=[1.0, 0.0, 1.0, 1.0])),
                           'torque_constants', 'zero'),
    'constants without their doubt': (content(effort=effort(torque_constants_std=None)),
                                      'torque_constants_std', 'missing'),
    'doubt in percent': (content(effort=effort(torque_constants_std=5.0)),
                         'torque_constants_std', '5.0'),
    'constants of a torque': (content(effort=effort(kind='motor_torque')), 'torque_constants',
                              'motor_current'),
    'configured load not said': (content(effort=effort(includes_configured_load=None)),
                                 'includes_configured_load', 'missing'),
    'configured load not given': (content(effort=effort(includes_configured_load=True)),
                                  'configured_load', 'missing'),
    'max_velocity short': (content(max_velocity=[1.0, 1.0]), 'max_velocity', '4 numbers'),
    'max_velocity zero': (content(max_velocity=[1.0, 1.0, 0.0, 1.0]), 'max_velocity', '0.0'),
    'max_acceleration negative': (content(max_acceleration=[1.0, -1.0, 1.0, 1.0]),
                                  'max_acceleration', '-1.0'),
    'max_torque a text': (content(max_torque='large'), 'max_torque', 'large'),
    'max_torque missing': (content(max_torque=None), 'max_torque', 'missing'),
    'allowed_torque of two': (content(allowed_torque=2.0), 'allowed_torque', '2.0'),
    'a key nobody knows': (content(payload=3.0), 'payload', 'know'),
    'a key of effort nobody knows': (content(effort=effort(unit='A')), 'unit', 'know')}


@pytest.mark.parametrize('case', WRONG)
def test_wrong_robot_files_are_refused_with_file_key_and_value(tmp_path, case):
    wrong, key, value = WRONG[case]
    path = tmp_path / 'arm.yaml'
    path.write_text(yaml.safe_dump(wrong))
    with pytest.raises(ConfigurationError) as caught:
        load_robot(path)
    message = str(caught.value)
    assert str(path) in message and key in message and value in message
    assert '\n' not in message


def test_a_branching_arm_is_refused():
    urdf = chain_urdf('zyyx').replace('<parent link="l1"/><child link="l2"/>',
                                      '<parent link="l0"/><child link="l2"/>')
    with pytest.raises(ConfigurationError, match='urdf.*(branches|serial)'):
        robot_from_content(content(urdf=urdf), 'test')


def test_a_floating_joint_is_refused():
    urdf = content()['urdf'].replace('type="revolute"', 'type="floating"', 1)
    with pytest.raises(ConfigurationError, match='more than one degree of freedom'):
        robot_from_content(content(urdf=urdf), 'test')


@pytest.mark.parametrize('mass', ['-1.5', '0', '0.0', '1,5', 'nan', 'inf', ''])
def test_a_mass_that_no_link_has_is_refused(mass):
    """Pinocchio took such links for weightless, or for what lifts the arm."""
    urdf = content()['urdf'].replace('<mass value="1.5"/>', f'<mass value="{mass}"/>')
    with pytest.raises(ConfigurationError, match=f'link l1: has a mass.*{mass}'):
        robot_from_content(content(urdf=urdf), 'test')


def test_frames_and_links_without_inertia_need_no_mass():
    zero = ('<link name="tip"><inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" '
            'iyy="0" iyz="0" izz="0"/></inertial></link>')
    urdf = content()['urdf'].replace('<link name="tip"/>', zero)
    urdf = re.sub('<link name="l1">.*?</link>', '<link name="l1"/>', urdf)
    assert robot_from_content(content(urdf=urdf), 'test').nominal_links[10] == 0.0


@pytest.mark.parametrize('text, what', [
    ('- j0\n- j1\n', 'not a mapping'), ('name: [\n', 'not YAML'), ('', 'not a mapping'),
    ('built: 2024-13-45\n', 'not YAML.*month'), ('a: ' + 2000 * '[', 'not YAML')])
def test_what_is_no_mapping_is_refused(tmp_path, text, what):
    path = tmp_path / 'arm.yaml'
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=what):
        load_robot(path)


@pytest.mark.parametrize('value', [10 ** 400, -10 ** 400, np.inf, True, 'ten', [1.0]])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ConfigurationError, match='here: mean: is not usable'):
        Section({'mean': value}, 'here').number('mean')


def test_a_robot_file_that_is_not_there(tmp_path):
    with pytest.raises(ConfigurationError, match='arm.yaml.*is not there.*new-robot'):
        load_robot(tmp_path / 'arm.yaml')


def test_defaults_are_stated():
    robot = robot_from_content(content(), 'test')
    assert robot.limits.allowed_torque == 0.8
    assert (robot.effort.torque_constants == 1.0).all()
    assert robot.effort.torque_constants_std == 0.0


def test_the_configured_load_is_read():
    robot = robot_from_content(content(effort=effort(
        includes_configured_load=True, configured_load={'mass': 1.5, 'com': [0, 0, 0.05]})), 't')
    assert robot.effort.configured_load.mass == 1.5


def written(tmp_path, declared, encoding):
    """Write a robot file whose URDF has an umlaut; return its path."""
    text = f'<?xml version="1.0" encoding="{declared}"?>\n<!-- Gr\xf6\xdfe -->{content()["urdf"]}'
    (tmp_path / 'arm.urdf').write_bytes(text.encode(encoding))
    (tmp_path / 'arm.yaml').write_text(yaml.safe_dump(content(urdf='arm.urdf')))
    return tmp_path / 'arm.yaml'


@pytest.mark.parametrize('declared, encoding', [
    ('ISO-8859-1', 'latin-1'), ('UTF-16', 'utf-16'), ('UTF-8', 'utf-8-sig')])
def test_a_urdf_may_have_the_encoding_that_it_declares(tmp_path, declared, encoding):
    robot = load_robot(written(tmp_path, declared, encoding))
    assert robot_from_content(robot.file.content, 'model').joints == chain(*'zyyx').joints


@pytest.mark.parametrize('declared', ['UTF-8', 'no_such_one', 'big5'])
def test_a_urdf_that_cannot_be_read_is_refused(tmp_path, declared):
    with pytest.raises(ConfigurationError, match='in the encoding that it declares'):
        load_robot(written(tmp_path, declared, 'latin-1'))


def test_the_kept_content_is_self_contained(tmp_path):
    (tmp_path / 'arm.urdf').write_text(content()['urdf'])
    (tmp_path / 'arm.yaml').write_text(yaml.safe_dump(content(urdf='arm.urdf')))
    robot = load_robot(tmp_path / 'arm.yaml')
    (tmp_path / 'arm.urdf').unlink()
    again = robot_from_content(robot.file.content, 'copy')
    np.testing.assert_array_equal(again.nominal_links, robot.nominal_links)
