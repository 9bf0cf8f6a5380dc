"""`hand_load diagnose`: find what a torque model lacks, add it, report before and after."""

from dataclasses import replace
import json
from pathlib import Path
import sys

from .recording_arguments import add_recording_arguments, topics

EXAMPLE = 'hand_load diagnose run1 run2 --model model.yaml --out diagnosis --test run3'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('recordings', nargs='+', metavar='BAG',
                        help='recordings without load or with a known one')
    parser.add_argument('--model', required=True, metavar='MODEL.yaml', help='torque model file')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder for report.html, report.json and model.yaml')
    parser.add_argument('--test', nargs='+', default=[], metavar='BAG',
                        help='recordings used only for the errors before and after; those with a '
                             'known load also for the error of the load estimate, and only for '
                             'that where nothing but its mass is known')
    parser.add_argument('--load', metavar='none|L.yaml', default=None,
                        help='load in all recordings but those to test on; without it each '
                             'load.yaml says')
    parser.add_argument('--fine-tune', default=None, metavar='ARTEFACT',
                        help='fine-tune this learned artefact (a folder, or the name of a shipped '
                             'one) from the better model into DIR/learned; takes minutes')
    parser.add_argument('--json', action='store_true', help='print report.json')
    add_recording_arguments(parser)


def run(args):
    """Diagnose, write report and model, say what was found."""
    from ..learning.artefact import CARD, read_artefact
    from ..files.load_file import load_of_argument
    from ..torque.model_file import read_model, write_model
    from ..files.recording_mark import refuse_repeats
    from ..report.diagnosis_folder import clear, diagnosis_folder
    from ..report.diagnosis_page import sentences
    from ..residual.diagnose import diagnose
    from ..residual.load_error import (known_torque, with_kept_artefact,
                                       with_load_errors)
    from ..files.shared_files import find_shared
    from .identify import dated, known_load, placed, stated_load
    model_path = find_shared(args.model, 'models')
    start = args.fine_tune and find_shared(args.fine_tune, 'learned')
    out = diagnosis_folder(args.out, (*args.recordings, *args.test, model_path, args.load,
                                      start and start / CARD))
    model = read_model(model_path)
    if start:
        read_artefact(start, model.robot)
    given = placed(*load_of_argument(args.load), args.load) if args.load else None
    load = known_load if given is None else lambda recording: given
    evidence = [_read(model, path, args, load)[0] for path in args.recordings]
    tests = [_read(model, path, args, stated_load) for path in args.test]
    refuse_repeats(evidence, [e for e, _, _ in tests])
    diagnosis, better = diagnose(model, evidence, [e for e, _, _ in filter(known_torque, tests)],
                                 _say)
    diagnosis = with_load_errors(diagnosis, model, better, tests)
    out.mkdir(parents=True, exist_ok=True)
    clear(out)
    # Where no joint slid, the model was held against nothing.
    told = diagnosis.sliding is not None
    write_model(out / 'model.yaml', dated(better, diagnosis.sliding) if told else better)
    if diagnosis.correction is not None:
        write_model(out / 'model_with_correction.yaml',
                    dated(diagnosis.correction.model, diagnosis.correction.sliding))
    if start and better is not model:
        # Minutes of training lie ahead: what is known is not to be lost with them.
        _write_report(out, replace(diagnosis, training=True))
        # Here, because it brings torch in, which nothing else of a diagnosis needs.
        from ..residual.fine_tuning import with_fine_tuning
        diagnosis = with_fine_tuning(diagnosis, better, out / 'model.yaml', start,
                                     out / 'learned', tests, _say)
    else:
        if start:
            _say('nothing was added to the model: the artefact is left as it is')
        diagnosis = with_kept_artefact(diagnosis, model, better, tests)
    content = _write_report(out, diagnosis)
    print(json.dumps(content) if args.json
          else '\n'.join((*sentences(diagnosis), *diagnosis.cannot_tell,
                          str(out / 'report.html'))))
    return 0


def _write_report(out, diagnosis):
    """Write report.json and report.html; return what is in the first."""
    from ..report.diagnosis_json import diagnosis_content
    from ..report.diagnosis_page import write_page
    content = diagnosis_content(diagnosis)
    (out / 'report.json').write_text(json.dumps(content, indent=2) + '\n', encoding='utf-8')
    write_page(out / 'report.html', diagnosis)
    return content


def _read(model, path, args, load_of):
    """Return (Evidence, Recording, LoadParameters) of one recording; load_of(Recording)."""
    from ..identification.evidence import prepare
    from ..stream.joint_stream import motion_of
    from ..recording import read_recording
    recording = read_recording(path, **topics(args))
    load = load_of(recording)
    motion, rejected = motion_of(model.robot, recording)
    evidence = prepare(model.robot, Path(path).name, motion, load, recording, rejected)
    _say(f'{Path(path).name}: {len(motion.stamp)} samples, rejected {sum(rejected.values())}')
    return evidence, recording, load


def _say(text):
    print(text, file=sys.stderr, flush=True)
