"""`hand_load identify`: a torque model from recordings without load, or with a known one."""

from dataclasses import replace
from datetime import datetime
from pathlib import Path
import sys

from ..files.load_file import placed
from .recording_arguments import add_recording_arguments, topics

# Share of the motion from which on it is said that it repeats what was shown before.
REPEATED = 0.25
EXAMPLE = """
hand_load identify run1 run2 --robot ur10e --out model.yaml
hand_load identify run3 run4 --model diagnosis/model.yaml --out model.yaml
"""


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('recordings', nargs='+', metavar='BAG', help='rosbag2 recordings')
    arm = parser.add_mutually_exclusive_group(required=True)
    arm.add_argument('--robot', metavar='R.yaml',
                     help='robot file, or the name of a shipped one')
    arm.add_argument('--model', metavar='MODEL.yaml',
                     help='identify again what this model holds, its effects with their shapes '
                          'and what `diagnose` has added; its figures are what is known before')
    parser.add_argument('--out', required=True, metavar='MODEL.yaml', help='model file to write')
    parser.add_argument('--effects', metavar='a,b,...', default=None,
                        help='effects to declare (default: all the package knows); not with '
                             '--model')
    parser.add_argument('--load', metavar='none|L.yaml', default=None,
                        help='load in all recordings; without it each load.yaml says')
    add_recording_arguments(parser)


def read_evidence(robot, args):
    """Return a list of Evidence: recordings of the arguments, with --load or their load.yaml."""
    from ..identification.clipped_effort import clipped_efforts
    from ..checks.declared_load import another_load
    from ..identification.evidence import prepare
    from ..stream.joint_stream import motion_of
    from ..files.load_file import load_of_argument
    from ..recording import read_recording
    from ..files.recording_mark import refuse_repeats
    from ..stream.rejected_input import in_words
    from ..identification.useless_recording import refuse_useless
    given = placed(*load_of_argument(args.load), args.load) if args.load else None
    evidence = []
    for path in args.recordings:
        recording = read_recording(path, **topics(args))
        load = given if given is not None else known_load(recording)
        motion, rejected = motion_of(robot, recording)
        evidence.append(prepare(robot, Path(path).name, motion, load, recording,
                                rejected))
        _say(f'{Path(path).name}: {len(motion.stamp)} samples, rejected '
             f'{sum(rejected.values())}' + (f' ({in_words(rejected)})' if rejected else ''))
        refuse_useless(robot, evidence[-1])
        another = another_load(robot, recording, load)
        if another:
            _say(f'WARNING: {Path(path).name}: {another}')
    refuse_repeats(evidence)
    for said in clipped_efforts(robot, evidence):
        _say(said)
    return evidence


def run(args):
    """Identify, write the model and say how good it is."""
    from ..identification.identify import check_effects
    from ..identification.identified_sense import nonsense, refuse_nonsense
    from ..identification.mixed_temperatures import mixed_temperatures
    from ..torque.model_file import read_model, SCHEMA, write_model
    from ..files.output_file import output_file
    from ..residual.measured.repeats import share_repeated
    from ..robot import load_robot
    from ..files.shared_files import find_shared
    from ..torque.unknown_friction import told_of_unknown_friction
    source = find_shared(args.model, 'models') if args.model else \
        find_shared(args.robot, 'robots')
    out = output_file(args.out, SCHEMA, (*args.recordings, source, args.load))
    before = read_model(source) if args.model else None
    robot = before.robot if before else load_robot(source)
    effects = _effects(args)
    check_effects(effects or ())
    evidence = read_evidence(robot, args)
    model = _identified(robot, before, evidence, effects)
    senseless = nonsense(model, evidence)
    refuse_nonsense(robot, evidence, senseless)
    write_model(out, dated(model, model.residuals.sliding))
    _report(model, args.out, before)
    for said in filter(None, (*senseless.values(), told_of_unknown_friction(model),
                              *mixed_temperatures(robot, evidence))):
        _say(said)
    again = share_repeated(evidence)
    if again > REPEATED:
        _say(f'{100.0 * again:.0f} % of the motion repeats what was shown before: what is held '
             'out may have its twin in what is fitted, and errors in other motions may be larger '
             'than those; record other motions too (hand_load excite)')
    return 0


def _effects(args):
    from ..errors import ConfigurationError
    if args.effects is None:
        return None
    if args.model:
        raise ConfigurationError('--effects', 'does not go with --model, which has its effects',
                                 args.effects, todo='leave one of them out')
    return args.effects.split(',')


def _identified(robot, before, evidence, effects):
    """Return the TorqueModel, everything in it estimated together; before: the old or None."""
    from ..identification.identify import identify
    from ..residual.add import identified_again
    if before is None:
        return identify(robot, evidence, effects, progress=_say)
    return identified_again(before, before.uses, evidence)


def dated(model, sliding):
    """Return a TorqueModel that was diagnosed now; sliding (n,) [Nm] as of Residuals."""
    now = datetime.now().astimezone().isoformat(timespec='seconds')
    return replace(model, diagnosed=now, residuals=replace(model.residuals, sliding=sliding))


def known_load(recording):
    """Return the load of a recording's load.yaml, placed; refuse a recording that has none."""
    return placed(stated_load(recording), recording.load_known, f'{recording.path}: load.yaml')


def stated_load(recording):
    """Return the load of a recording's load.yaml, a mass alone too; refuse one that has none."""
    from ..errors import RecordingError
    if recording.load is None:
        raise RecordingError(f'{recording.path}: does not say its load; add a load.yaml (none, or '
                             'mass, com, inertia) or give --load')
    return recording.load


def _say(text):
    print(text, file=sys.stderr, flush=True)


def _report(model, out, before):
    from ..residual.add import SHOWN
    print(f'{out}: {model.robot.name}, {len(model.recordings)} recordings')
    print(f'{"joint":24s} {"held-out RMS":>12s} {"Coulomb":>9s} {"viscous":>14s}')
    for name, still, rms, level, slope in zip(
            model.robot.joints, model.residuals.unmoved, model.noise, model.friction_level(),
            model.viscous_friction()):
        print(f'{name:24s} ' + ('not moved' if still else
              f'{rms:9.3f} Nm {level:6.2f} Nm {slope:7.2f} Nm s/rad'))
    floor = [] if before is None else [
        name for name, rms, old in zip(model.robot.joints, model.noise, before.noise)
        if abs(rms / (SHOWN ** 0.5 * old) - 1.0) < 1e-6]
    if floor:
        print(f'{", ".join(floor)}: as much is stated as is sure of the model before; these '
              'recordings show less, and need not show all that its own did')
