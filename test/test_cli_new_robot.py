"""`hand_load new-robot`: what the URDF says is taken over, the rest is asked for."""

import re

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.robot_draft import read_chain, TO_COMPLETE
from hand_load_estimator.robot import load_robot
import pytest

LINK = ('<link name="{0}"><inertial><mass value="{1}"/><origin xyz="0.1 0 0"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>')
JOINT = ('<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>'
         '<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>{4}</joint>')
LIMIT = '<limit lower="-2" upper="2.5" velocity="1.5" effort="40"/>'


def urdf(tmp_path, extra='', first_limit=LIMIT):
    parts = [LINK.format(name, mass) for name, mass in
             (('base', 5), ('l1', 4), ('l2', 3), ('l3', 2), ('flange', 0.1), ('finger', 0.1))]
    parts += [JOINT.format('j1', 'revolute', 'base', 'l1', first_limit),
              JOINT.format('j2', 'revolute', 'l1', 'l2', LIMIT),
              JOINT.format('on', 'continuous', 'l2', 'l3', '<limit velocity="3" effort="9"/>'),
              JOINT.format('j3-flange', 'fixed', 'l3', 'flange', ''),
              JOINT.format('grip', 'prismatic', 'flange', 'finger', LIMIT)]
    path = tmp_path / 'arm.urdf'
    path.write_text(f'<robot name="tiny">{"".join(parts)}{extra}</robot>')
    return path


def draft(tmp_path, path, *more):
    out = tmp_path / 'arm.yaml'
    assert main(['new-robot', str(path), '--out', str(out), *more]) == 0
    return out


def completed(out):
    text = out.read_text().replace(f'mass: {TO_COMPLETE}', 'mass: 2.0')
    text = text.replace(f'kind: {TO_COMPLETE}', 'kind: motor_torque')
    out.write_text(text.replace(TO_COMPLETE, '5.0'))
    return out


def test_completed_draft_loads_with_what_the_urdf_says(tmp_path, capsys):
    out = draft(tmp_path, urdf(tmp_path))
    assert ('rated_load.mass, rated_load.com, effort.kind, max_acceleration'
            in capsys.readouterr().out)
    robot = load_robot(completed(out))
    # The flange is where an arm ends by habit; the gripper's finger is not part of it.
    assert robot.joints == ('j1', 'j2', 'on')
    assert robot.load_frame == 'flange'
    assert robot.limits.velocity.tolist() == [1.5, 1.5, 3.0]
    assert robot.limits.torque.tolist() == [40.0, 40.0, 9.0]
    assert robot.limits.upper[:2].tolist() == [2.5, 2.5]


def test_every_value_to_complete_is_refused_until_it_is_there(tmp_path):
    out = draft(tmp_path, urdf(tmp_path, first_limit=''))
    text, marks = out.read_text(), 0
    # Commented-out lines are offers, not values to complete.
    for line in [line for line in text.splitlines()
                 if TO_COMPLETE in line and not line.lstrip().startswith('#')]:
        key = line.split(':')[0].strip()
        complete = completed(out).read_text()
        value = re.escape(line.split(':')[0]) + ':.*'
        out.write_text(re.sub(value, lambda _: line, complete, count=1, flags=re.M))
        with pytest.raises(ConfigurationError, match=f'{key}.*{TO_COMPLETE}'):
            load_robot(out)
        out.write_text(text)
        marks += 1
    assert marks == 6


def test_tip_is_chosen_or_refused(tmp_path, capsys):
    path = urdf(tmp_path)
    assert [j.name for j in read_chain(path, 'finger').joints] == ['j1', 'j2', 'on', 'grip']
    assert read_chain(path, 'l3').frames == ('l3', 'flange')
    for tip, why in (('nothing', 'not a link'), ('base', 'not behind'),
                     ('l2', 'too few movable joints')):
        assert main(['new-robot', str(path), '--out', str(tmp_path / 'r.yaml'),
                     '--tip', tip]) == 2
        assert why in capsys.readouterr().err


def test_without_a_usual_tip_the_arm_ends_before_its_fingers(tmp_path, capsys):
    """As a Panda with its hand, whose links have no usual name."""
    path = urdf(tmp_path)
    path.write_text(path.read_text().replace('flange', 'hand'))
    robot = load_robot(completed(draft(tmp_path, path)))
    assert robot.joints == ('j1', 'j2', 'on') and robot.load_frame == 'hand'
    said = capsys.readouterr().out
    assert 'left out as a gripper behind hand: grip' in said and '--tip' in said


def test_an_arm_of_slides_alone_is_taken_whole(tmp_path):
    path = urdf(tmp_path)
    path.write_text(re.sub('revolute|continuous', 'prismatic', path.read_text())
                    .replace('flange', 'hand'))
    chain = read_chain(path)
    assert [j.name for j in chain.joints] == ['j1', 'j2', 'on', 'grip'] and not chain.beyond


def test_names_yaml_would_misread_are_quoted(tmp_path):
    path = urdf(tmp_path)
    robot = load_robot(completed(draft(tmp_path, path)))
    assert robot.joints[2] == 'on'


@pytest.mark.parametrize('name', ['{x', '@j', '*x', 'a]', 'a: b', 'a, b', 'j #1', '12'])
def test_names_of_any_characters_are_kept(tmp_path, name):
    path = urdf(tmp_path)
    path.write_text(path.read_text().replace('"tiny"', f'"{name}"').replace('"j2"', f'"{name}"'))
    robot = load_robot(completed(draft(tmp_path, path)))
    assert robot.name == name and robot.joints == ('j1', name, 'on')


@pytest.mark.parametrize('old, new, why', [
    ('parent link="base"', 'parent link="flange"', 'behind itself'),
    ('parent link="base"', 'parent link="zz"', 'joint j1: parent'),
    ('<child link="l2"/>', '<child/>', 'joint j2: child'),
    ('<link name="l1">', '<link>', 'has a link without a name'),
    ('joint name="j2"', 'joint', 'has a joint without a name')])
def test_what_is_no_tree_is_refused(tmp_path, capsys, old, new, why):
    path = urdf(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    assert main(['new-robot', str(path), '--out', str(tmp_path / 'r.yaml')]) == 2
    said = capsys.readouterr().err.strip()
    assert why in said and '\n' not in said


@pytest.mark.parametrize('content, why', [
    ('nonsense', 'not XML'), ('<sdf/>', 'not a URDF'),
    ('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>', 'xacro'),
    ('<robot name="r"><link name="a"/></robot>', 'no movable joint'),
    ('<robot name="r"><link name="a"/><link name="b"/><joint name="only" type="revolute">'
     '<parent link="a"/><child link="b"/></joint></robot>', "too few movable joints; got 'only'")])
def test_what_is_no_arm_is_refused(tmp_path, capsys, content, why):
    path = tmp_path / 'x.urdf'
    path.write_text(content)
    assert main(['new-robot', str(path), '--out', str(tmp_path / 'r.yaml')]) == 2
    assert why in capsys.readouterr().err
    assert not (tmp_path / 'r.yaml').exists()


def test_existing_file_is_kept(tmp_path, capsys):
    out = tmp_path / 'arm.yaml'
    out.write_text('mine')
    assert main(['new-robot', str(urdf(tmp_path)), '--out', str(out)]) == 2
    assert out.read_text() == 'mine'
