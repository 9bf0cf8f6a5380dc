"""Diagnose every measured set: python -m real_recordings DATA OUT [SET...]."""

import json
from pathlib import Path
import shutil
import subprocess
import sys
import time

from hand_load_estimator.benchmark.provenance import commit_now
from hand_load_estimator.benchmark.real import LOADED
from hand_load_estimator.benchmark.real_robots import ARMS, write_robot_file
from hand_load_estimator.benchmark.real_sets import linked, SETS, stage
from hand_load_estimator.errors import HandLoadError
from hand_load_estimator.recording import read_recording
from hand_load_estimator.residual.load_error import run_through
from hand_load_estimator.torque.model_file import read_model

from .table import table

# No set takes longer [s] unless something hangs.
LONGEST = 1800.0


class SetFailed(Exception):
    """A step of a set did not succeed; says why in one sentence."""


def hand_load(*arguments):
    """Run one command as a process of its own; its last line becomes the reason of a failure."""
    command = [sys.executable, '-m', 'hand_load_estimator', *map(str, arguments)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        raise SetFailed(f'hand_load {arguments[0]}: took longer than {LONGEST:g} s') from None
    if done.returncode:
        said = done.stderr.strip().splitlines() or ['says nothing']
        raise SetFailed(f'{said[-1]} (exit {done.returncode})')


def diagnose_set(name, data, out, exchanged=False):
    """
    Return the content of report.json of one set.

    data, out: Paths; reports go to out/<set>, what they are made from to out/inputs/<set>;
    exchanged: learned from what is else the test, and tested on the rest, below out/exchanged.
    """
    out = out / 'exchanged' if exchanged else out
    chosen, inputs, reports = SETS[name], out / 'inputs' / name, out / name
    for folder in (inputs, reports):
        shutil.rmtree(folder, ignore_errors=True)
    train, test = stage(chosen, data / name, inputs)
    if exchanged:
        train, test = test, train
    robot = write_robot_file(name, data, inputs) if chosen.robot in ARMS else chosen.robot
    base = inputs / 'base.yaml'
    hand_load('identify', *train, '--robot', robot, '--effects', ','.join(chosen.effects),
              '--out', base)
    # Their masses are known and nothing more: enough for the error of the load estimate.
    test += [linked(data / name / run, inputs / run, {'mass': mass})
             for run, mass in LOADED.get(name, {}).items()]
    hand_load('diagnose', *train, '--model', base, '--out', reports, '--test', *test)
    return json.loads((reports / 'report.json').read_text(encoding='utf-8'))


def loads_of(name, data, out):
    """
    Return [(run, known mass, mass before, mass after)] [kg] of a set's loaded runs.

    With their signs, which the report's errors have not.
    """
    models = [read_model(path) for path in (out / 'inputs' / name / 'base.yaml',
                                            out / name / 'model.yaml')]
    return [(run, mass, *(_mass(model, data / name / run) for model in models))
            for run, mass in LOADED.get(name, {}).items()]


def _mass(model, run):
    return float(run_through(model, read_recording(run)).belief().mean[0])


def diagnose_sets(names, data, out, exchanged=False):
    """Return {set: report, or why there is none}, with a line of progress for each."""
    results, how = {}, ', parts exchanged' * exchanged
    for number, name in enumerate(names, start=1):
        print(f'{number} of {len(names)}: {name}{how}', end=' ', flush=True)
        start = time.monotonic()
        try:
            results[name] = diagnose_set(name, data, out, exchanged)
            said = f'{len(results[name]["effects"])} effects'
        except (SetFailed, HandLoadError, OSError, ValueError, KeyError) as error:
            results[name] = said = str(error)
        print(f'{time.monotonic() - start:.0f} s: {said}', flush=True)
    return results


def main(data, out, *names):
    """Write out/table.md; 0, or 1 when a set failed, or 2 for wrong arguments."""
    data, out = Path(data), Path(out)
    unknown = [name for name in names if name not in SETS]
    if unknown:
        print(f'error: no such set: {", ".join(unknown)}; allowed: {", ".join(SETS)}',
              file=sys.stderr)
        return 2
    if not data.is_dir():
        print(f'error: {data} is not there; give the folder that holds {", ".join(SETS)}',
              file=sys.stderr)
        return 2
    names = names or tuple(SETS)
    results, again = (diagnose_sets(names, data, out, exchanged) for exchanged in (False, True))
    out.mkdir(parents=True, exist_ok=True)
    loads = {name: loads_of(name, data, out) for name, result in results.items()
             if name in LOADED and not isinstance(result, str)}
    text = table(results, again, loads, {name: SETS[name].assumed for name in results})
    text += f'\nCommand: `scripts/real_diagnose`, commit {commit_now()}.\n'
    (out / 'table.md').write_text(text, encoding='utf-8')
    print(text)
    return int(any(isinstance(result, str) for result in results.values()))


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
