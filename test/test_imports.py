"""The rooms of DESIGN section 2 import only what they may; read from source but for the last."""

import ast
import os
import subprocess
import sys
from pathlib import PurePosixPath

import pytest
from ros_helpers import ROOT

PACKAGE = 'hand_load_estimator'
ROS = {'rclpy', 'rosgraph_msgs', 'builtin_interfaces', 'rcl_interfaces', 'std_msgs', 'std_srvs',
       'sensor_msgs', 'geometry_msgs', 'trajectory_msgs', 'diagnostic_msgs', 'control_msgs',
       'visualization_msgs'}
# What plant/ may know of the package: the load, the robot, and how files and errors are told.
KNOWN_TO_PLANT = {'load', 'files/load_file', 'robot', 'files/robot_file', 'files/configuration',
                  'errors'}
USERS_OF_PLANT = ('plant/', 'benchmark/', 'nodes/simulator', 'simulation/simulate',
                  'commands/simulate', 'commands/benchmark')


def module_of(path):
    """Return the dotted name of a source file."""
    parts = path.relative_to(ROOT).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


SOURCES = {module_of(path): path for path in sorted((ROOT / PACKAGE).rglob('*.py'))}


def imports_of(name):
    """Return the absolute dotted names a module imports, anywhere in its text."""
    path, found = SOURCES[name], set()
    package = name if path.name == '__init__.py' else name.rpartition('.')[0]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                up = package.split('.')[:len(package.split('.')) - node.level + 1]
                base = '.'.join([*up, *filter(None, [node.module])])
            found.add(base)
            found.update(f'{base}.{alias.name}' for alias in node.names)
    return found


IMPORTS = {name: imports_of(name) for name in SOURCES}


def room(name):
    """Return a module's place below the package, with a slash for its folder."""
    path = SOURCES[name].relative_to(ROOT / PACKAGE).with_suffix('')
    return str(PurePosixPath(path))


def importers(package):
    """Return the places that import a top-level package."""
    return {room(name) for name, found in IMPORTS.items()
            if any(f.split('.')[0] == package for f in found)}


def reached_from(name):
    """Return all modules of the package that importing a module brings in."""
    reached, todo = set(), [name]
    while todo:
        current = todo.pop()
        if current in reached or current not in SOURCES:
            continue
        reached.add(current)
        todo.extend(IMPORTS[current])
        todo.extend('.'.join(current.split('.')[:k]) for k in range(1, current.count('.') + 1))
    return reached


def test_the_reader_sees_imports():
    """Were the sources not found or not read, the rules below would hold of nothing."""
    assert f'{PACKAGE}.nodes.estimator_node' in SOURCES
    assert 'rclpy.node' in IMPORTS[f'{PACKAGE}.nodes.estimator_node']
    assert f'{PACKAGE}.load' in reached_from(f'{PACKAGE}.nodes.estimator_node')
    assert importers('mujoco')


@pytest.mark.parametrize('package', sorted(ROS))
def test_ros_only_in_nodes(package):
    assert all(place.startswith('nodes/') for place in importers(package))


def test_mujoco_only_in_plant_and_benchmark():
    assert all(place.startswith(('plant/', 'benchmark/')) for place in importers('mujoco'))


def test_torch_only_where_networks_are_trained_or_run():
    assert all(place.startswith(('learning/', 'estimators/', 'benchmark/'))
               for place in importers('torch'))


def test_plant_is_imported_only_by_who_simulates():
    for name, found in IMPORTS.items():
        if any(f == f'{PACKAGE}.plant' or f.startswith(f'{PACKAGE}.plant.') for f in found):
            assert room(name).startswith(USERS_OF_PLANT), name


def test_plant_knows_only_load_and_robot():
    for name in SOURCES:
        if not room(name).startswith('plant/'):
            continue
        own = {room(f) for f in IMPORTS[name] if f in SOURCES and not room(f).startswith('plant/')}
        own -= {'__init__'}
        assert own <= KNOWN_TO_PLANT, name


@pytest.mark.parametrize('start', [
    'nodes.estimator_node', 'nodes.controller_node', 'estimators.build', 'torque_model',
    'commands.estimate', 'commands.identify', 'commands.train', 'commands.learn_gp',
    'commands.diagnose'])
def test_what_estimates_and_learns_never_reaches_the_plant(start):
    reached = reached_from(f'{PACKAGE}.{start}')
    assert f'{PACKAGE}.{start}' in reached, 'the module is not there'
    assert not [name for name in reached if name.startswith(f'{PACKAGE}.plant')]


def folder_of(name):
    """Return the room a module lies in, or its own name in the root."""
    return room(name).partition('/')[0]


def test_no_two_rooms_import_one_another():
    """But where a trained artefact is read; torque_model.py is the face of its own room."""
    uses = {(folder_of(name), folder_of(f)) for name, found in IMPORTS.items()
            for f in found if f in SOURCES and folder_of(f) != '__init__'}
    both = {frozenset(pair) for pair in uses if pair[::-1] in uses and pair[0] != pair[1]}
    assert both == {frozenset(('estimators', 'learning')), frozenset(('torque', 'torque_model'))}


def test_the_page_of_rooms_says_what_each_is():
    page = (ROOT / 'doc' / 'rooms.md').read_text()
    told = {line.split('|')[1].strip(): line.split('|')[2].strip()
            for line in page.splitlines() if line.startswith('| `')}
    modules = {name: path for name, path in SOURCES.items() if name.count('.') == 1
               and path.name != '__main__.py'}
    assert len(modules) > 20
    assert told == {
        f'`{path.name if path.name != "__init__.py" else path.parent.name}`':
            ast.get_docstring(ast.parse(path.read_text())).splitlines()[0]
        for path in modules.values()}


def test_training_never_reaches_the_plant():
    rooms = [name for name in SOURCES if room(name).startswith(('learning/', 'effects/'))]
    assert rooms
    for name in rooms:
        assert not [r for r in reached_from(name) if r.startswith(f'{PACKAGE}.plant')], name


def test_nothing_is_pickled():
    for package in ('pickle', 'cPickle', 'dill', 'shelve'):
        assert not importers(package)
    # It sends jobs to a cluster there; nothing of it is written to a file.
    assert importers('joblib') <= {'benchmark/execute'}


def test_the_nodes_of_an_arm_load_neither_torch_nor_mujoco():
    """The README's second world installs neither for them; networks run in numpy."""
    code = ('import sys; import hand_load_estimator.nodes.controller_node, '
            'hand_load_estimator.nodes.estimator_node; '
            'from hand_load_estimator.estimators.build import build_pipeline; '
            'print(*(build_pipeline("ur10e", name).method.name for name in ("lstm", "bayes")), '
            '*(name in sys.modules for name in ("torch", "mujoco", "rosbags", "matplotlib")))')
    said = subprocess.run([sys.executable, '-c', code], check=True, capture_output=True, text=True,
                          env={**os.environ, 'PYTHONPATH': str(ROOT)}).stdout.split()
    assert said == ['lstm', 'bayes', *['False'] * 4]
