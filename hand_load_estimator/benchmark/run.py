"""Run suites in parallel, resume what was done, write the pages."""

from dataclasses import dataclass
import hashlib
from pathlib import Path

from ..errors import ConfigurationError
from ..estimators.build import shipped_artefact
from ..files.shared_files import find_shared
from ..learning.artefact import CARD, WEIGHTS
from ..robot import load_robot
from . import ageing, pushes, suggestion
from .arms import ARMS, friction_told, urdf_of, write_arm
from .change_scores import change_scores
from .changes import change_jobs, CHANGES, measure_job
from .contestants import chosen_methods, DEFAULT, FUNCTION, KNOWN_LOAD, ON_FUNCTION
from .cost import cost_jobs, cost_scores, measure_cost
from .cost_page import cost_blocks
from .document import Heading, Text, write_pages
from .effect_cases import plants_of
from .execute import measure_all, PROCESSES, runner_of
from .goals import goal_rows, goal_table
from .hidden_scores import hidden_scores
from .joined import refuse_mixture, run_name, write_index, write_scores
from .measure import measure_plant
from .offline import chosen_rivals
from .oracle_scores import oracle_scores
from .other_pages import change_blocks, retraining_blocks, soak_blocks
from .page import leading, suite_blocks
from .provenance import commit_now, same_run, sources
from .real import measure_set, real_jobs, real_scores
from .real_page import real_blocks
from .retraining import measure_retraining, retraining_jobs, retraining_scores
from .scores import (complete, inertia_scores, network_shares, offline_scores, overview, score,
                     verdicts)
from .soak import run_soak
from .suites import cases_of, recorded_words, SUITES

SCHEMA = 'hand_load/benchmark/1'
# Suites that are no accuracy suite on one simulated arm.
ARM_SUITES = tuple(f'arms-{name}' for name in ARMS)
OTHERS = ('changes', 'suggestion', 'pushes', 'real', 'cost', 'soak', 'retraining', 'ageing')
_OF_DIAGNOSIS = ('retraining', 'ageing')
# `all` is everything the goals need; `development` is for looking, `effects` and _OF_DIAGNOSIS
# judge diagnosis and what goes with it.
ALL = (*(name for name in SUITES if name != 'development'), *ARM_SUITES,
       *(name for name in OTHERS if name not in _OF_DIAGNOSIS))


@dataclass(frozen=True)
class Options:
    """
    How suites are run.

    robot: name or file; learned: artefact folder or None; cases: per suite, or None for the
    suite's own; methods: names or None for all; rivals: offline ones; hours: of running in
    `changes` and of `soak`, or None for theirs; data: folder of the real recordings; development:
    on seeds for looking and choosing; workers, backend: as of measure_all.
    """

    robot: str = 'ur10e'
    learned: str | None = None
    cases: int | None = None
    methods: tuple | None = None
    rivals: tuple = ()
    hours: float | None = None
    data: str = '../shared/data'
    development: bool = False
    workers: int | None = None
    backend: str = PROCESSES


def _artefact(robot_path, options):
    """Return a digest of the default method's artefact for a robot file, or None without one."""
    folder = options.learned or shipped_artefact(load_robot(robot_path))
    if not folder:
        return None
    digest = hashlib.sha256()
    for name in (WEIGHTS, CARD):
        digest.update((Path(folder) / name).read_bytes())
    return digest.hexdigest()


def _key(suite, robot_path, options):
    """Return what results depend on: suite, robot file, artefact, choices, the code."""
    return {'suite': suite, 'robot': Path(robot_path).read_text('utf-8'),
            'artefact': _artefact(robot_path, options), 'commit': commit_now(),
            'sources': sources(), 'methods': list(chosen_methods(options.methods)),
            'rivals': list(options.rivals), 'cases': options.cases, 'hours': options.hours,
            'data': options.data, 'development': options.development}


def _run(options, command, commit):
    """Return what joins runs to one table: the robot asked for, also beside other arms."""
    robot_path = find_shared(options.robot, 'robots')
    return {'command': command, 'commit': commit,
            'robot': hashlib.sha256(Path(robot_path).read_bytes()).hexdigest(),
            'artefact': _artefact(robot_path, options), 'development': options.development}


def suite_names(text):
    """Return the suites of a comma-separated list; `arms` and `all` stand for several."""
    out = []
    for name in text.split(','):
        known = {'arms': ARM_SUITES, 'all': ALL}.get(name, (name,))
        if known == (name,) and name not in (*SUITES, *ARM_SUITES, *OTHERS):
            raise ConfigurationError('--suite', 'is not known', name,
                                     ', '.join([*SUITES, 'arms', *OTHERS, 'all',
                                                'effects (by itself)']))
        out += [one for one in known if one not in out]
    return tuple(out)


def _robot_path(name, options, folder):
    if name not in ARM_SUITES:
        return find_shared(options.robot, 'robots')
    arm = name.removeprefix('arms-')
    return write_arm(arm, urdf_of(ARMS[arm]), folder / 'robots')


def _accuracy(name, robot_path, options, raw, write):
    """Return scores.json's content and the page's blocks but for the goals, of one suite."""
    suite = SUITES['base' if name in ARM_SUITES else name]
    draw = 'base' if name in ARM_SUITES else name
    count = options.cases or (40 if name in ARM_SUITES else None)
    jobs = {f'plant_{plant}': (draw, str(robot_path), plant, part, options.learned,
                               options.methods, tuple(options.rivals))
            for plant, part in cases_of(suite, count, options.development)}
    found = measure_all(measure_plant, jobs, raw, options.workers, options.backend, write)
    results = [r for part in found.values() for r in part]
    if not complete(results):
        raise ConfigurationError(raw, 'holds no case in which the arm moved long enough',
                                 todo='see what failed above, or ask for more --cases')
    robot = load_robot(robot_path)
    scores = score(results, robot.rated_load.mass)
    hidden = name == 'undeclared'
    content = {'identified': recorded_words(suite),
               'overview': overview(results), 'scores': scores,
               'inertia': inertia_scores(results) if name == 'inertia' else {},
               'hidden': hidden_scores(results, leading(scores)) if hidden else {},
               'oracle': oracle_scores(results, leading(scores)) if hidden else {},
               'network': network_shares(scores), 'offline': offline_scores(results),
               'failed': len(jobs) - len(found),
               'fell_back': [m for m in chosen_methods(options.methods) if m not in scores]}
    about = suite.about + (f'; {robot.name}: {friction_told(robot)}' if name in ARM_SUITES else '')
    told = verdicts(scores) if name in ('base', 'development') and DEFAULT in scores else ()
    return content, lambda command, commit: suite_blocks(
        f'Accuracy on the {name} suite', about, content, told, command, commit)


def _some(found, raw):
    """Return what was measured; raises ConfigurationError where that is nothing."""
    if not found:
        raise ConfigurationError(raw, 'holds nothing: every part failed',
                                 todo='see above why')
    return found


def _other(name, robot_path, options, raw, write):
    """Return content and blocks of a suite that is no accuracy suite."""
    run = (options.workers, options.backend, write)
    if name == 'changes':
        jobs = change_jobs(str(robot_path), options.cases or CHANGES,
                           10.0 if options.hours is None else options.hours, options.learned,
                           options.methods, options.development)
        found = _some(measure_all(measure_job, jobs, raw, *run), raw)
        return change_scores(found), change_blocks
    if name == 'suggestion':
        method = chosen_methods(options.methods)[0]
        jobs = suggestion.suggestion_jobs(
            str(robot_path), options.cases or suggestion.CASES, method, options.learned,
            options.development)
        found = _some(measure_all(suggestion.measure_suggestion, jobs, raw, *run), raw)
        return suggestion.suggestion_scores(found, method), suggestion.suggestion_blocks
    if name == 'pushes':
        jobs = pushes.push_jobs(str(robot_path), options.cases or pushes.CASES, options.learned,
                                options.methods, options.development)
        found = _some(measure_all(pushes.measure_push, jobs, raw, *run), raw)
        return pushes.push_scores(found), pushes.push_blocks
    if name == 'ageing':
        method = chosen_methods(options.methods)[0]
        jobs = ageing.ageing_jobs(str(robot_path), options.cases, method, options.learned,
                                  options.development)
        found = _some(measure_all(ageing.measure_ageing, jobs, raw, *run), raw)
        return ageing.ageing_scores(found, method), ageing.ageing_blocks
    if name == 'real':
        jobs = real_jobs(options.data, None, raw, options.methods, tuple(options.rivals))
        found = _some(measure_all(measure_set, jobs, raw, *run), raw)
        left_out = [m for m in chosen_methods(options.methods) if FUNCTION.get(m) == KNOWN_LOAD]
        return {**real_scores(found), 'left_out': left_out}, real_blocks
    if name == 'cost':
        jobs = cost_jobs(options.robot, options.learned, options.methods)
        found = _some(measure_all(measure_cost, jobs, raw, *run, alone=True), raw)
        left_out = [m for m in chosen_methods(options.methods) if m in ON_FUNCTION]
        return {**cost_scores(found), 'left_out': left_out}, cost_blocks
    if name == 'retraining':
        jobs = retraining_jobs(robot_path, plants_of(options.development), options.learned,
                               raw, options.cases)
        # In this process: training takes all cores by itself.
        found = measure_all(measure_retraining, jobs, raw, workers=0)
        return retraining_scores(found), retraining_blocks
    method = chosen_methods(options.methods)[0]
    content = run_soak(options.robot, method, options.learned if method == DEFAULT else None,
                       24.0 if options.hours is None else options.hours, raw, write)
    return content, soak_blocks


def _measure(name, options, out, command, write):
    """Measure one suite into a folder of its own below `out`; return the Markdown of its page."""
    folder = out / run_name(name, options.cases, options.hours,
                            (*(options.methods or ()), *options.rivals))
    raw = folder / 'raw'
    raw.mkdir(parents=True, exist_ok=True)
    robot_path = _robot_path(name, options, folder)
    key = _key(name, robot_path, options)
    same_run(raw, key)
    measured = _other if name in OTHERS else _accuracy
    content, blocks = measured(name, robot_path, options, raw, write)
    content = {'schema': SCHEMA, 'suite': name, 'run': _run(options, command, key['commit']),
               **content}
    write_scores(folder, content)
    page = blocks(command, key['commit']) if measured is _accuracy else [
        *blocks(content), Text(f'Command: `{command}`, commit {key["commit"]}.')]
    goals = [row for row in goal_rows([(folder.name, content)]) if row.reached is not None]
    if goals:
        page = [*page, Heading('Goals of issue 4 that this suite measures'),
                goal_table(goals, with_runs=False)]
    return write_pages(folder, page)


def run_suites(suites, options, folder, command, write=print):
    """
    Measure suites below `folder`; return the Markdown of the page.

    Each has a folder there, named by the suite and what was chosen, with raw results,
    scores.json, README.md, index.html and pictures. The folder itself has the table of goals over
    all runs that are there, of this call or of others. The page is the suite's where it is one.
    """
    names, out = suite_names(suites), Path(folder)
    _refuse_unasked(names, options)
    options = _checked(options, out)
    pages, failed = [], {}
    for name in names:
        write(f'suite {name}')
        try:
            pages.append(_measure(name, options, out, command, write))
        except ConfigurationError as error:
            if len(names) == 1:
                raise
            failed[name] = str(error)
            write(failed[name])
        # A day's suites: what is there so far can be read, and a kill loses none of it.
        index = write_index(out, SCHEMA, failed)
    return pages[0] if len(names) == 1 else index


def _refuse_unasked(names, options):
    """Refuse an option that none of the suites asks, rather than leave it out unsaid."""
    every = {*SUITES, *ARM_SUITES, *OTHERS}
    for option, suites, told in (
            ('cases', every - {'real', 'cost', 'soak'}, 'all suites but real, cost and soak'),
            ('rivals', every - {*OTHERS} | {'real'}, 'the accuracy suites and real'),
            ('hours', {'changes', 'soak'}, 'changes and soak'),
            ('learned', every - {'real'}, 'all suites but real, whose arms it is not of'),
            ('data', {'real'}, 'real')):
        value = getattr(options, option)
        if value != getattr(Options, option) and suites.isdisjoint(names):
            raise ConfigurationError(
                f'--{option}', f'is not asked by {", ".join(names)}',
                ', '.join(value) if isinstance(value, tuple) else value, told)


def _checked(options, out):
    """Return the options, refused here rather than after hours where they are wrong."""
    chosen_methods(options.methods)
    chosen_rivals(options.rivals)
    runner_of(options.backend)
    refuse_mixture(out, _run(options, '', ''))
    return options
