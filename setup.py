"""Install with pip, or with colcon into a ROS 2 workspace."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'hand_load_estimator'
SHARE = Path('share') / PACKAGE


def tree(folder):
    """Return data_files entries for a folder and all below it, each into the same place."""
    folders = {}
    for path in sorted(Path(folder).rglob('*')):
        if path.is_file() and '__pycache__' not in path.parts:
            folders.setdefault(path.parent, []).append(str(path))
    return [(str(SHARE / parent), files) for parent, files in folders.items()]


setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (str(SHARE), ['package.xml', 'LICENSE']),
        *tree('config'),
        *tree('launch'),
    ],
    python_requires='>=3.11',
    # Without versions, so that a distribution's packages count; requirements.txt has the tested
    # ones. rclpy and the messages belong to ROS and are not asked of PyPI here.
    install_requires=['evox', 'gpytorch', 'matplotlib', 'mujoco', 'numpy', 'pin', 'PyYAML',
                      'rosbags', 'safetensors', 'scipy', 'torch'],
    extras_require={
        'ros': ['ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces'],
        'test': ['colcon-common-extensions', 'example-robot-data', 'pytest',
                 'pytest-xdist'],
        # hand_load benchmark --rivals, --backend.
        'rivals': ['figaroh', 'mujoco[sysid]'],
        'cluster': ['joblib'],
    },
    license='Apache-2.0',
    description="Estimate the load on a robot's hand, with variance, and use it",
    entry_points={'console_scripts': [
        'simulator_node = hand_load_estimator.nodes.start:simulator',
        'estimator_node = hand_load_estimator.nodes.start:estimator',
        'controller_node = hand_load_estimator.nodes.start:controller',
        'hand_load = hand_load_estimator.cli:main',
    ]},
)
