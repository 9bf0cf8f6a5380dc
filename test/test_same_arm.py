"""A model goes with the arm it was identified on: told by where the joints lie, not by names."""

from dataclasses import replace
from types import SimpleNamespace

from core_helpers import exact_model
import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_pipeline, shipped_artefact
from hand_load_estimator.files.same_arm import arm_difference
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.nodes.controller_settings import model_from_parameters
from hand_load_estimator.robot import load_robot, robot_from_content
from hand_load_estimator.torque.model_file import write_model

# What stands in the URDF of the UR10 (public figures) in place of the UR10e's.
UR10 = (('0 0 0.1807', '0 0 0.1273'), ('-0.6127 0 0', '-0.612 0 0'),
        ('-0.57155 0 0.17415', '-0.5723 0 0.163941'), ('0 -0.11985', '0 -0.1157'),
        ('0 0.11655', '0 0.0922'))
# Larger than what factory calibrations of UR arms say: a few millimetres and hundredths of rad.
CALIBRATED = (('0 0 0.1807" rpy="0 0 0', '0.0002 0 0.1812" rpy="0 0 0.00004'),
              ('-0.6127 0 0" rpy="0 0 0', '-0.6151 0 0.0008" rpy="0.0203 -0.0152 0.0009'),
              ('-0.57155 0 0.17415" rpy="0 0 0',
               '-0.5742 0.0011 0.1764" rpy="-0.0212 0.0131 0.001'),
              ('0 -0.11985', '0.0004 -0.1221'), ('0 0.11655', '0.0003 0.1182'))


def another_arm(robot, replacements):
    """Return a Robot of the same joints with other text in its URDF."""
    urdf = robot.file.urdf
    for old, new in replacements:
        assert urdf.count(old) == 1, old
        urdf = urdf.replace(old, new)
    return robot_from_content({**robot.file.content, 'name': 'another', 'urdf': urdf}, 'test')


@pytest.fixture(scope='module')
def ur10e():
    return load_robot(find_shared('ur10e', 'robots'))


@pytest.mark.parametrize('replacements', [
    (), CALIBRATED,
    # The same arm on a pedestal, turned by a quarter.
    [('0 0 0.1807" rpy="0 0 0', '0.3 0.1 0.9807" rpy="0 0 1.5708')],
    # A turn of pi each way is the same.
    [('0 0 0" rpy="1.570796327 0 0"', '0 0 0" rpy="-1.570796327 3.14159265 3.14159265"')]])
def test_the_same_arm_is_the_same_calibrated_or_not(ur10e, replacements):
    other = another_arm(ur10e, replacements)
    assert arm_difference(ur10e, other) == arm_difference(other, ur10e) == ''


@pytest.mark.parametrize('replacements, said', [
    (UR10, 'wrist_3_joint lies 24 mm from where another has it'),
    ([('-0.57155 0 0.17415', '-0.57155 0 0.18615')], 'wrist_1_joint lies 12 mm'),
    ([('-0.6127 0 0" rpy="0 0 0', '-0.6127 0 0" rpy="0 0 1.5708')],
     'elbow_joint is turned by 1.57'),
    ([('0 0 0.1807" rpy="0 0 0"/>\n    <axis xyz="0 0 1', '0 0 0.1807" rpy="0 0 0"/>\n    '
       '<axis xyz="0 0 -1')], 'shoulder_pan_joint is turned by 3.14')])
def test_another_arm_of_the_same_joint_names_is_told(ur10e, replacements, said):
    assert arm_difference(ur10e, another_arm(ur10e, replacements)).startswith(said)


def test_a_model_of_another_arm_is_refused_with_both_names(ur10e, tmp_path):
    model = exact_model()
    write_model(tmp_path / 'ur10.yaml', replace(model, robot=another_arm(ur10e, UR10)))
    with pytest.raises(ConfigurationError, match='another robot.*another: wrist_3.*ur10e has it'):
        build_pipeline(tmp_path / 'ur10.yaml', 'bayes', None, 'ur10e')
    write_model(tmp_path / 'same.yaml', replace(model, robot=another_arm(ur10e, CALIBRATED)))
    assert build_pipeline(tmp_path / 'same.yaml', 'bayes', None, 'ur10e').method.name == 'bayes'


def test_the_controller_refuses_a_model_of_another_arm_too(tmp_path, ur10e):
    write_model(tmp_path / 'ur10.yaml', replace(exact_model(), robot=another_arm(ur10e, UR10)))
    values = SimpleNamespace(robot='ur10e', model=str(tmp_path / 'ur10.yaml'))
    with pytest.raises(ConfigurationError, match='belongs to another robot.*wrist_3'):
        model_from_parameters(values)
    values = SimpleNamespace(robot='ur10e_current', model='ur10e')
    with pytest.raises(ConfigurationError, match='belongs to another robot.*motor_current'):
        model_from_parameters(values)


@pytest.mark.parametrize('change, said', [
    ({'load_frame': 'flange'}, '`load_frame`.*flange, .* from wrist_3_joint.*tool0'),
    ({'gravity': [0.0, 0.0, 9.81]}, r'`gravity`.*\[0.0, 0.0, 9.81\] m/s'),
    ({'reference_temperature': 30.0}, '`reference_temperature`.*30'),
    ({'effort': {'kind': 'motor_torque', 'includes_configured_load': True,
                 'configured_load': {'mass': 5.0, 'com': [0.0, 0.0, 0.1]}}},
     r'`effort`.*configured_load \[5.0, .*configured_load none')])
def test_a_model_of_another_frame_gravity_or_temperature_is_refused_by_both(
        ur10e, tmp_path, change, said):
    other = robot_from_content({**ur10e.file.content, **change}, 'test')
    write_model(tmp_path / 'model.yaml', replace(exact_model(), robot=other))
    values = SimpleNamespace(robot='ur10e', model=str(tmp_path / 'model.yaml'))
    with pytest.raises(ConfigurationError, match=said):
        model_from_parameters(values)
    with pytest.raises(ConfigurationError, match=said):
        build_pipeline(tmp_path / 'model.yaml', 'bayes', None, 'ur10e')


def test_another_arm_of_the_same_joint_names_has_no_network(ur10e):
    assert shipped_artefact(ur10e) is not None
    assert shipped_artefact(another_arm(ur10e, CALIBRATED)) is not None
    assert shipped_artefact(another_arm(ur10e, UR10)) is None
