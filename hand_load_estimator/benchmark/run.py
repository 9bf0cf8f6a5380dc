"""Run a suite in parallel, resume what was done, write the pages."""

from concurrent.futures import as_completed, ProcessPoolExecutor
import hashlib
import json
import os
from pathlib import Path
import subprocess
import time

from .. import seeds
from ..errors import ConfigurationError
from ..estimators.build import shipped_artefact
from ..learning.artefact import CARD, WEIGHTS
from ..robot import load_robot
from ..shared_files import find_shared
from .measure import measure_plant
from .page import markdown, picture
from .scores import overview, score, verdicts

# suite: (plant seeds, case seeds, cases per plant)
SUITES = {
    'base': (seeds.BENCHMARK_PLANTS[:25], seeds.BENCHMARK_CASES, 8),
    'development': (seeds.DEVELOPMENT_PLANTS[50:58], seeds.DEVELOPMENT_CASES, 8)}


def commit_now():
    """Return the code's commit, with a word when it was changed since."""
    try:
        out = subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], text=True,
                             capture_output=True, cwd=Path(__file__).parent, check=False)
    except OSError:
        return 'unknown'
    commit = out.stdout.strip() or 'unknown'
    changed = subprocess.run(['git', 'status', '--porcelain', '--untracked-files=no'], text=True,
                             capture_output=True, cwd=Path(__file__).parent, check=False)
    return f'{commit} with changes' if changed.stdout.strip() else commit


def _key(suite, robot_path, learned):
    """Return what results depend on: suite, robot file, artefact and the code's commit."""
    artefact = learned or shipped_artefact(load_robot(robot_path))
    if artefact is None:
        raise ConfigurationError('--learned', 'is needed: no artefact is shipped for this robot')
    digest = hashlib.sha256()
    for name in (WEIGHTS, CARD):
        digest.update((Path(artefact) / name).read_bytes())
    return {'suite': suite, 'robot': Path(robot_path).read_text('utf-8'),
            'artefact': digest.hexdigest(), 'commit': commit_now()}


def same_run(raw, key):
    """Note what the raw results belong to; refuse to mix two runs."""
    note = raw / 'key.json'
    if note.exists() and json.loads(note.read_text('utf-8')) != key:
        raise ConfigurationError(raw, 'holds results of another suite, robot, artefact or commit',
                                 todo='remove it or give another --out')
    note.write_text(json.dumps(key), encoding='utf-8')


def run_suite(suite, robot_name, learned, folder, command, write=print):
    """Measure a suite into `folder`: raw results per plant, scores.json, README.md, mass.png."""
    if suite not in SUITES:
        raise ConfigurationError('--suite', 'is not known', suite,
                                 ', '.join([*SUITES, 'effects']))
    plants, case_seeds, per_plant = SUITES[suite]
    raw = Path(folder) / 'raw'
    raw.mkdir(parents=True, exist_ok=True)
    robot_path = find_shared(robot_name, 'robots')
    key = _key(suite, robot_path, learned)
    same_run(raw, key)
    jobs = [(str(robot_path), plant, list(case_seeds[k * per_plant:(k + 1) * per_plant]),
             learned, str(raw)) for k, plant in enumerate(plants)]
    began, paths = time.monotonic(), []
    with ProcessPoolExecutor(os.cpu_count() or 1) as pool:
        running = [pool.submit(measure_plant, *job) for job in jobs]
        for done, job in enumerate(as_completed(running), start=1):
            paths.append(job.result())
            left = (time.monotonic() - began) / done * (len(jobs) - done)
            write(f'plant {done}/{len(jobs)}  {left / 60.0:.1f} min left')
    results = [r for path in sorted(paths) for r in json.loads(path.read_text('utf-8'))]
    robot = load_robot(robot_path)
    scores, counts = score(results, robot.rated_load.mass), overview(results)
    out = Path(folder)
    (out / 'scores.json').write_text(json.dumps(
        {'schema': 'hand_load/benchmark/1', 'suite': suite, 'overview': counts,
         'scores': scores}, indent=1) + '\n', encoding='utf-8')
    page = markdown(scores, counts, verdicts(scores), command, key['commit'])
    (out / 'README.md').write_text(page, encoding='utf-8')
    picture(scores, out / 'mass.png')
    return page
