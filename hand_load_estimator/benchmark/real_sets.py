"""Which runs of each measured set are learned from and which are kept for the test."""

from dataclasses import dataclass

import numpy as np
import yaml

from ..errors import RecordingError
from ..files.load_file import ASSUMED
from ..recording import JointSample, read_recording, RecordingWriter

# Where a set has one recording only: this much of its motion is learned from, the rest tested.
TRAIN_SHARE = 0.7
# An arm none of whose joints is faster stands [rad/s].
MOVING = 0.02
# What every model starts from; the diagnosis has to find the rest. Sensors behind the gear see
# friction all the same (of the link's bearings and seals, and their own hysteresis), but no rotor.
BASE_EFFECTS = ('link_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')
BEFORE_THE_SENSOR = ('rotor_inertia',)


@dataclass(frozen=True)
class RecordingSet:
    """
    One measured set.

    robot: name in ARMS, or of a robot file shipped with the package; train, test: names of runs
    (without test runs the one train run is cut in two); load: what every run carries, `none` or
    the content of a load.yaml; motor_side: rotor and gear are in the effort; assumed: what makes
    that load an assumption, empty where the source states it.
    """

    robot: str
    train: tuple
    test: tuple = ()
    load: object = 'none'
    motor_side: bool = True
    assumed: str = ''

    @property
    def effects(self):
        """Names of the effects the model starts from."""
        return BASE_EFFECTS + BEFORE_THE_SENSOR * self.motor_side


_UNSTATED = 'none, because the source states none'
SETS = {
    'ur10e': RecordingSet(
        'ur10e_current',
        ('ident_20_02_10-30sec_12harm', 'ident_20_02_12-50sec_12harm',
         'ident_20_02_05-20sec_8harm', 'ident_20_02_06-20sec_10harm', 'ident_20_01_31-unload',
         'ident_19_12_23_free'),
        ('ident_20_02_05-20sec_12harm', 'ident_20_02_10-20sec_7harm',
         'ident_20_02_12-40sec_12harm', 'ident_20_02_19_14harm50sec',
         'valid_20_01_17-ptp_10_points')),
    'ur10': RecordingSet('ur10', ('exciting_trajectory',), assumed=_UNSTATED),
    'panda': RecordingSet('panda', ('exciting_trajectory_1',), motor_side=False,
                          assumed=_UNSTATED),
    # 1 and 2 are one motion twice; 3 is another, faster one.
    'lwr4': RecordingSet('lwr4', ('measurements_1', 'measurements_2'), ('measurements_3',),
                         motor_side=False, assumed=_UNSTATED),
    # The runs are the source's own choice: A to identify, B and C to validate.
    'kr300': RecordingSet(
        'kr300', ('trajectory_A',), ('trajectory_B', 'trajectory_C'),
        {'mass': 150.0, 'com': [0.0, 0.0, 0.1], ASSUMED: True},
        assumed='150 kg, concluded from gravity torques that the source keeps beside the logs'),
    'staubli_tx40': RecordingSet('staubli_tx40', ('exciting_trajectory',)),
    'nist_ur5': RecordingSet(
        'nist_ur5', ('halfspeed_1p6lb_1',), assumed='none: the label says 0.73 kg, but the '
        'currents show no such weight (`hand_load check`)'),
}


def _write_load(folder, load):
    text = load if load == 'none' else yaml.safe_dump(load, default_flow_style=None)
    (folder / 'load.yaml').write_text(f'{text.rstrip()}\n', encoding='utf-8')


def linked(run, folder, load):
    """Make a folder that shows a run's files and states its load; return the folder."""
    folder.mkdir(parents=True)
    for file in run.iterdir():
        if file.name != 'load.yaml':
            (folder / file.name).symlink_to(file.resolve())
    _write_load(folder, load)
    return folder


def cut(samples, share):
    """
    Return the samples before and after `share` of a recording's time in motion.

    samples: JointSamples and TemperatureSamples. Time in motion, not time: some logs end at rest.
    """
    moving = [s.stamp for s in samples
              if isinstance(s, JointSample) and np.max(np.abs(s.velocity)) > MOVING]
    if not moving:
        raise RecordingError('the arm never moves')
    end = moving[int(share * len(moving))]
    return [s for s in samples if s.stamp < end], [s for s in samples if s.stamp >= end]


def _cut_run(run, folder, load):
    """Write the first and the last part of a run as recordings; return their folders."""
    parts = []
    samples = read_recording(run, with_load=False).samples
    for part, chosen in zip(('first', 'last'), cut(samples, TRAIN_SHARE)):
        path = folder / f'{run.name}_{part}'
        with RecordingWriter(path) as writer:
            for sample in chosen:
                writer.write(sample)
        _write_load(path, load)
        parts.append(path)
    return [parts[0]], [parts[1]]


def stage(chosen, source, folder):
    """
    Return (train, test): lists of recording folders, made below `folder`, that state their load.

    chosen: a RecordingSet; source: Path of the set's data; folder: a new one. Raises OSError and
    RecordingError.
    """
    folder.mkdir(parents=True)
    if not chosen.test:
        return _cut_run(source / chosen.train[0], folder, chosen.load)
    return tuple([linked(source / run, folder / run, chosen.load) for run in runs]
                 for runs in (chosen.train, chosen.test))
