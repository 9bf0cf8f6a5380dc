"""`hand_load simulate`: a recording of the simulated arm, with its load.yaml."""

from pathlib import Path
import shutil
import sys
import time

from ..errors import ConfigurationError
from ..files.load_file import load_of_argument, placed, write_load_file
from ..files.output_file import output_folder
from ..files.shared_files import find_shared
from ..load import LoadParameters
from ..motions.trajectory import read_trajectory_csv
from ..number_argument import number
from ..plant import JointEvent, read_effects, simulate_motion
from ..recording import JointSample, RecordingWriter, TemperatureSample
from ..robot import load_robot
from ..seeds import SHIPPED_MODEL_PLANT
from .simulate_motions import MOTIONS, named_motion

EXAMPLE = """
hand_load simulate --robot ur10e --out empty --motion excite --duration 60
hand_load simulate --robot ur10e --out loaded --load load.yaml --temperature 15 --speed 0.5
"""
SETTLE = 0.5      # [s] at rest before the motion
EPOCH = 1000.0    # [s] first stamp; a bag that starts at zero is taken for one without a clock
_DURATION = 30.0  # [s]
_PROGRESS = 0.5   # [s] between two lines


def add_arguments(parser):
    """Add the arguments of simulate."""
    parser.add_argument('--robot', metavar='R.yaml', required=True,
                        help='robot file, or the name of a shipped one')
    parser.add_argument('--out', metavar='BAG', required=True, help='recording to write')
    parser.add_argument('--load', metavar='L.yaml', default='none',
                        help='load on the hand: none or a load file (default: none)')
    parser.add_argument('--temperature', metavar='C', type=number(-20.0, 90.0),
                        help='of arm and room at the start [degC] (default: the robot file\'s '
                             'reference temperature)')
    parser.add_argument('--effects', metavar='E.yaml', help='hidden effects the arm has')
    parser.add_argument('--motion', metavar='NAME|CSV', default='pick_place',
                        help=f'{", ".join(MOTIONS)} or a motion file (default: pick_place)')
    parser.add_argument('--seed', metavar='N', type=number(0, 2 ** 31, int),
                        default=SHIPPED_MODEL_PLANT,
                        help=f'draws the arm and its noise (default: {SHIPPED_MODEL_PLANT}, the '
                             'arm of the shipped ur10e model)')
    parser.add_argument('--motion-seed', metavar='N', type=number(0, 2 ** 31, int), default=0,
                        help='draws the motion, noise and state of rest (default: 0)')
    parser.add_argument('--duration', metavar='S', type=number(1.0, 36000.0),
                        help=f'of a motion by name [s] (default: {_DURATION:g})')
    parser.add_argument('--rate', metavar='HZ', type=number(30.0, 1000.0), default=500.0,
                        help='of joint states (default: 500)')
    parser.add_argument('--speed', metavar='0..1', type=number(0.01, 1.0), default=1.0,
                        help='share of the quickest (default: 1)')


def _motion(args, robot):
    """Return the Trajectory of --motion; raises ConfigurationError."""
    if args.motion in MOTIONS:
        return named_motion(args.motion, robot, args.duration or _DURATION, args.speed,
                            args.motion_seed)
    if not Path(args.motion).is_file():
        raise ConfigurationError('--motion', 'is neither a motion nor a file', args.motion,
                                 f'{", ".join(MOTIONS)} or the path of a motion CSV')
    if args.duration is not None:
        raise ConfigurationError('--duration', 'does not go with a motion file', args.duration,
                                 'motions by name', 'leave it out: the file has its own')
    return read_trajectory_csv(args.motion, robot.joints)[1].at_speed(args.speed)


def samples_of(event, joints):
    """Return the recording samples of one event of the plant."""
    stamp = EPOCH + event.stamp
    if isinstance(event, JointEvent):
        return [JointSample(stamp, joints, event.position, event.velocity, event.effort)]
    return [TemperatureSample(stamp, joint, value)
            for joint, value in zip(joints, event.celsius)]


def run(args):
    """Simulate and write the recording."""
    out = output_folder(args.out)
    robot = load_robot(find_shared(args.robot, 'robots'))
    load = placed(*load_of_argument(args.load), args.load)
    effects = read_effects(args.effects, robot) if args.effects else ()
    motion = _motion(args, robot)
    temperature = (robot.file.reference_temperature if args.temperature is None
                   else args.temperature)
    events = simulate_motion(robot, motion.time, motion.position, motion.velocity,
                             motion.acceleration, settle=SETTLE, seed=args.seed,
                             run=args.motion_seed, load=load,
                             effects=effects, start_temperature=temperature, rate=args.rate)
    began = time.monotonic()
    try:
        count = _write(out, events, robot.joints, load, SETTLE + motion.end)
    except ConfigurationError:
        # Half of a motion that no arm makes is no recording.
        shutil.rmtree(out)
        raise
    took = time.monotonic() - began
    print(f'{args.out}: {SETTLE + motion.end:.1f} s of {robot.file.name}, {count} joint states, '
          f'load {_told(load)}; {(SETTLE + motion.end) / took:.1f} times real time')
    return 0


def _told(load):
    return f'{load.mass:g} kg' if load.mass else 'none'


def _write(out, events, joints, load, duration):
    """Write recording and load.yaml; return the number of joint states."""
    writer = RecordingWriter(out)
    count, told = 0, time.monotonic()
    with writer:
        for event in events:
            for sample in samples_of(event, joints):
                writer.write(sample)
            count += isinstance(event, JointEvent)
            if sys.stderr.isatty() and time.monotonic() - told > _PROGRESS:
                told = time.monotonic()
                print(f'\r{event.stamp:6.1f} of {duration:.1f} s', end='', file=sys.stderr)
        if sys.stderr.isatty():
            print('\r' + ' ' * 40 + '\r', end='', file=sys.stderr)
    write_load_file(out / 'load.yaml', load if load.mass else LoadParameters())
    return count
