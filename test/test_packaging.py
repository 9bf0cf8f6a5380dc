"""The same tree installs with pip, builds with colcon, and the built executables run."""

import ast
import os
import runpy
import shutil
import signal
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from ros_helpers import ROOT, Listener, NodeProcess, node_environment
from sensor_msgs.msg import JointState
from test_imports import IMPORTS, PACKAGE, ROS

from hand_load_estimator.nodes.qos import OUTPUT, measurement
from hand_load_estimator.simulation.own_domain import free_domain

# What is built serves several tests: one process for all of them.
pytestmark = pytest.mark.xdist_group('installed')
EXECUTABLES = ('simulator_node', 'estimator_node', 'controller_node', 'hand_load')
# Import name -> rosdep key, where they differ.
KEYS = {'yaml': 'python3-yaml', 'numpy': 'python3-numpy', 'scipy': 'python3-scipy',
        'matplotlib': 'python3-matplotlib', 'torch': 'python3-pytorch-pip',
        'mujoco': 'python3-mujoco-pip', 'rosbags': 'python3-rosbags-pip',
        'safetensors': 'python3-safetensors-pip', 'gpytorch': 'python3-gpytorch-pip',
        'evox': 'python3-evox-pip'}
# Rivals and cluster backends of the benchmark are asked for by name, and told when missing.
OPTIONAL = {'absl', 'figaroh', 'joblib'}


def copy_tree(target):
    """Copy what belongs to the package, and nothing that was built."""
    shutil.copytree(ROOT, target, ignore=shutil.ignore_patterns(
        '.git', '.venv', '__pycache__', 'build', 'install', 'log', 'out', '*.egg-info',
        '.pytest_cache'))
    return target


def clean_environment():
    """Return an environment in which this source tree is not on the path."""
    return {key: value for key, value in os.environ.items()
            if key not in ('PYTHONPATH', 'AMENT_PREFIX_PATH', 'COLCON_PREFIX_PATH')}


@pytest.fixture(scope='module')
def workspace(tmp_path_factory):
    """Return the install prefix of a real colcon build."""
    folder = tmp_path_factory.mktemp('workspace')
    copy_tree(folder / 'src' / PACKAGE)
    colcon = Path(sys.executable).parent / 'colcon'
    built = subprocess.run([colcon, '--log-base', 'log', 'build'], cwd=folder, text=True,
                           capture_output=True, env=clean_environment())
    assert built.returncode == 0, built.stdout + built.stderr
    return folder / 'install' / PACKAGE


@pytest.fixture(scope='module')
def pip_prefix(tmp_path_factory):
    """Return the prefix of a real pip installation; the wheels it needs are here already."""
    folder = tmp_path_factory.mktemp('pip')
    source = copy_tree(folder / 'source')
    subprocess.run([sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps', '--no-index',
                    '--no-build-isolation', '--ignore-installed', '--prefix', folder / 'prefix',
                    source], check=True, env=clean_environment())
    return folder / 'prefix'


def site_packages(prefix):
    """Return the folder of a prefix that Python imports from."""
    (found,) = prefix.glob('lib/python3.*/site-packages')
    return found


def test_every_folder_of_code_is_a_package():
    """A folder without __init__.py works in the source tree and is missing when installed."""
    folders = {path.parent for path in (ROOT / PACKAGE).rglob('*.py')}
    assert [str(f) for f in folders if not (f / '__init__.py').is_file()] == []


def test_colcon_installs_executables_marker_and_shared_files(workspace):
    share = workspace / 'share' / PACKAGE
    for name in EXECUTABLES:
        assert os.access(workspace / 'lib' / PACKAGE / name, os.X_OK), name
    assert (workspace / 'share/ament_index/resource_index/packages' / PACKAGE).is_file()
    assert (share / 'package.xml').is_file()
    for folder in ('config', 'launch'):
        here = {p.relative_to(ROOT) for p in (ROOT / folder).rglob('*')
                if p.is_file() and '__pycache__' not in p.parts}
        there = {p.relative_to(share) for p in (share / folder).rglob('*') if p.is_file()}
        assert here == there and here, folder


@pytest.mark.parametrize('prefix', ['workspace', 'pip_prefix'])
def test_installed_code_finds_its_shared_files(prefix, request):
    prefix = request.getfixturevalue(prefix)
    code = ('import hand_load_estimator as h; from hand_load_estimator.files.shared_files import '
            'find_shared; print(h.__file__); print(find_shared("ur10e", "robots"))')
    said = subprocess.run(
        [sys.executable, '-c', code], text=True, capture_output=True, cwd='/', check=True,
        env={**clean_environment(), 'PYTHONPATH': str(site_packages(prefix))}).stdout.split()
    assert said == [str(site_packages(prefix) / PACKAGE / '__init__.py'),
                    str(prefix / 'share' / PACKAGE / 'config/robots/ur10e.yaml')]


def test_pip_installs_entry_points_and_they_answer(pip_prefix):
    for name in EXECUTABLES:
        assert os.access(pip_prefix / 'bin' / name, os.X_OK), name
    said = subprocess.run(
        [pip_prefix / 'bin' / 'hand_load', '--help'], text=True, capture_output=True, check=True,
        cwd='/', env={**clean_environment(), 'PYTHONPATH': str(site_packages(pip_prefix))}).stdout
    assert 'demo' in said and 'estimate' in said


def sourced(workspace, domain):
    """Return the environment of a shell that has sourced the workspace, on a domain."""
    base = {key: value for key, value in node_environment(domain).items()
            if key in clean_environment() or key.startswith('ROS_')}
    said = subprocess.run(['bash', '-c', f'. {workspace.parent / "setup.bash"} && env -0'],
                          env=base, check=True, capture_output=True, text=True).stdout
    return dict(line.split('=', 1) for line in said.split('\0') if line)


def executable_of(package, name, environment):
    """Return the path `ros2 run PACKAGE NAME` starts: by the ament index, below lib/PACKAGE."""
    code = 'import sys, ament_index_python as a; print(a.get_package_prefix(sys.argv[1]))'
    prefix = subprocess.run([sys.executable, '-c', code, package], env=environment, check=True,
                            capture_output=True, text=True).stdout.strip()
    found = [path for path in (Path(prefix) / 'lib' / package).rglob(name)
             if os.access(path, os.X_OK)]
    assert len(found) == 1, found
    return found[0]


def test_built_nodes_come_up_publish_and_stop_cleanly(workspace):
    """What `ros2 run` would start: all three on one domain, SIGTERM or Ctrl-C, exit code 0."""
    with free_domain() as domain, Listener(domain) as listener:
        joint_states = listener.listen(JointState, '/joint_states', measurement(1000))
        diagnostics = listener.listen(DiagnosticArray, '/diagnostics', OUTPUT)
        environment = sourced(workspace, domain)
        nodes = {
            name: NodeProcess(
                executable_of(PACKAGE, f'{name}_node', environment), domain,
                environment=environment,
                arguments=['--ros-args', '--params-file',
                           workspace / 'share' / PACKAGE / 'config' / f'{name}.yaml'])
            for name in ('simulator', 'estimator', 'controller')}
        try:
            def speaking():
                return {status.name.split(':')[0].split('/')[-1]
                        for message in diagnostics for status in message.status}

            def all_speak():
                for node in nodes.values():
                    assert node.process.poll() is None, node.output
                return joint_states and speaking() >= set(nodes)
            listener.until(all_speak, 'a joint state and diagnostics of every node')
            signals = (signal.SIGTERM, signal.SIGINT, signal.SIGTERM)
            codes = {name: node.stop(number) for (name, node), number
                     in zip(reversed(nodes.items()), signals)}
            said = '\n'.join(node.output for node in nodes.values())
            assert codes == dict.fromkeys(nodes, 0), said
            assert 'Traceback' not in said
        finally:
            for node in nodes.values():
                node.kill()


@pytest.mark.skipif(shutil.which('ros2') is None, reason='no ros2 command: it is not on PyPI')
def test_ros2_run_starts_a_built_node(workspace):
    """The command line of the README, Ctrl-C as a terminal sends it to both processes."""
    with free_domain() as domain, Listener(domain) as listener:
        diagnostics = listener.listen(DiagnosticArray, '/diagnostics', OUTPUT)
        node = NodeProcess(
            shutil.which('ros2'), domain, environment=sourced(workspace, domain), group=True,
            arguments=['run', PACKAGE, 'estimator_node', '--ros-args', '--params-file',
                       workspace / 'share' / PACKAGE / 'config' / 'estimator.yaml'])
        try:
            listener.until(lambda: diagnostics, 'diagnostics')
            assert node.stop(signal.SIGINT) == 0, node.output
            assert 'Traceback' not in node.output
        finally:
            node.kill()


def test_package_xml_names_every_run_time_import():
    package = ElementTree.parse(ROOT / 'package.xml').getroot()
    assert package.get('format') == '3'
    assert package.findtext('export/build_type') == 'ament_python'
    declared = {element.text for element in package.findall('exec_depend')}
    imported = {found.split('.')[0] for names in IMPORTS.values() for found in names}
    third_party = imported - set(sys.stdlib_module_names) - {PACKAGE, ''} - OPTIONAL
    assert {'numpy', 'rclpy'} <= third_party
    assert {KEYS.get(name, name) for name in third_party} <= declared
    assert ROS - OPTIONAL <= declared


def test_setup_asks_for_the_wheels_requirements_pin():
    source = (ROOT / 'setup.py').read_text()
    pinned = [line.split('==')[0].split('[')[0] for line in
              (ROOT / 'requirements.txt').read_text().splitlines() if '==' in line]
    assert len(pinned) > 8
    for name in pinned:
        assert f"'{name}" in source or name == 'setuptools', name


def installed_for(*names):
    """
    Return {distribution: version} of the requirements (with extras) and what they bring in.

    Without what one of them asks for in an exact version, as torch does for its CUDA parts.
    """
    found, todo = {}, [Requirement(name) for name in names]
    while todo:
        wanted = todo.pop()
        key = (canonicalize_name(wanted.name), frozenset(wanted.extras))
        if key in found:
            continue
        found[key] = metadata.version(wanted.name)
        extras = wanted.extras or {''}
        todo += [needed for needed in map(Requirement, metadata.requires(wanted.name) or [])
                 if not str(needed.specifier).startswith('==') and (
                     needed.marker is None
                     or any(needed.marker.evaluate({'extra': extra}) for extra in extras))]
    return {name: version for (name, _), version in found.items()}


def test_constraints_pin_everything_that_is_installed():
    """What is not pinned is another version tomorrow; networkx, which torch brings, once was."""
    lines = [line for file in ('requirements.txt', 'requirements-test.txt')
             for line in (ROOT / file).read_text().splitlines() if '==' in line]
    pins = {canonicalize_name(name): version for name, version in (
        line.split('==') for line in (ROOT / 'constraints.txt').read_text().splitlines()
        if '==' in line)}
    installed = installed_for(*lines)
    assert len(installed) > 100
    # A build is told by a suffix, 2.13.0+cpu.
    assert {name: version.split('+')[0] for name, version in installed.items()} == {
        name: pins.get(name) for name in installed}


def test_launch_file_declares_what_it_uses():
    """`launch` is not a wheel, so the file is read, not run: names used are names declared."""
    tree = ast.parse((ROOT / 'launch' / 'hand_load.launch.py').read_text())
    functions = [node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    assert 'generate_launch_description' in functions
    called = [node for node in ast.walk(tree) if isinstance(node, ast.Call)
              and isinstance(node.func, ast.Name)]
    declared = {node.args[0].value for node in called if node.func.id in ('_argument', '_switch')
                and isinstance(node.args[0], ast.Constant)}
    used = {node.args[0].value for node in called if node.func.id == 'LaunchConfiguration'
            and isinstance(node.args[0], ast.Constant)}
    assert used == declared
    assert {'robot', 'model', 'namespace', 'use_sim_time', 'record'} <= declared
    nodes = {node.args[0].value for node in called if node.func.id == '_node'
             and isinstance(node.args[0], ast.Constant)}
    assert nodes == {'simulator', 'estimator', 'controller'}


def test_the_launch_file_records_every_topic_of_the_readme_that_tells_something():
    tree = ast.parse((ROOT / 'launch' / 'hand_load.launch.py').read_text())
    (recorded,) = [ast.literal_eval(node.value) for node in tree.body
                   if isinstance(node, ast.Assign) and node.targets[0].id == 'RECORDED']
    interface = (ROOT / 'README.md').read_text().split('## Interface')[1].split('| service |')[0]
    topics = {line.split('`')[1] for line in interface.splitlines() if line.startswith('| `')}
    # A clock is made again when a bag is played; markers are drawn from the rest.
    assert {*recorded} == {*topics, 'dynamic_joint_states'} - {'/clock', 'estimator/markers'}


class Kept(SimpleNamespace):
    """Stands in for anything of `launch`, and keeps what it is given."""

    def __init__(self, *values, **named):
        super().__init__(values=values, **named)

    def perform(self, context):
        return context[self.values[0]]


@pytest.fixture
def launched(monkeypatch):
    """Return launched(**arguments) -> {node: parameters beside its file's}, without `launch`."""
    for name in ('launch', 'launch.actions', 'launch.conditions', 'launch.substitutions',
                 'launch_ros', 'launch_ros.actions', 'launch_ros.parameter_descriptions',
                 'launch_ros.substitutions'):
        module = ModuleType(name)
        module.__getattr__ = lambda wanted: Kept
        monkeypatch.setitem(sys.modules, name, module)
    launch_file = runpy.run_path(ROOT / 'launch' / 'hand_load.launch.py')
    (actions,) = launch_file['generate_launch_description']().values
    (late,) = [action.function for action in actions if hasattr(action, 'function')]
    default = {action.values[0]: action.default_value for action in actions
               if hasattr(action, 'default_value')}

    def launch(**arguments):
        return {node.name: {name: getattr(value, 'values', [value])[0]
                            for given in node.parameters[1:] for name, value in given.items()}
                for node in late({**default, **arguments})}
    return launch


def test_launch_file_moves_no_arm_and_makes_none_up_unless_told_to(launched):
    assert set(launched()) == {'estimator'}
    assert set(launched(simulate='true')) == {'estimator', 'simulator'}
    assert set(launched(control='true')) == {'estimator', 'controller'}


def test_launch_file_leaves_to_parameter_files_what_nobody_gives(launched):
    """What is handed on wins over the files: an empty model, or a robot that nobody asked for."""
    assert launched(control='true') == {'estimator': {}, 'controller': {}}
    mine = {'robot': 'my.yaml', 'model': 'model.yaml'}
    assert launched(control='true', **mine) == {'estimator': mine, 'controller': mine}


@pytest.mark.parametrize('given, passed', [('', True), ('false', False), ('true', True)])
def test_launched_nodes_hear_the_simulators_clock_unless_told_otherwise(launched, given, passed):
    nodes = launched(simulate='true', control='true', robot='my.yaml', use_sim_time=given)
    assert nodes['simulator'] == {'robot': 'my.yaml'}
    for name in ('estimator', 'controller'):
        assert nodes[name] == {'robot': 'my.yaml', 'use_sim_time': passed}


def test_scripts_run_in_bash_and_are_executable():
    for script in ('scripts/demo', 'scripts/test', '.ci/run'):
        assert os.access(ROOT / script, os.X_OK), script
    for script in ('scripts/demo', 'scripts/test', 'scripts/environment', '.ci/run'):
        subprocess.run(['bash', '-n', ROOT / script], check=True)
