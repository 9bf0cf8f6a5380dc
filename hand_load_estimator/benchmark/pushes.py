"""The pushes suite: a push on the hand while a load is carried, and what it leaves behind."""

import numpy as np

from .. import seeds
from .cases import Case, case_run, draw_case
from .contestants import (chosen_methods, Contestant, functions_of, our_contestants,
                          OUR_MODEL)
from .document import Heading, Table, Text
from .measure import robot_and_models
from .rivals import LeastSquares
from .suites import CASES_PER_PLANT

CASES = 40
FORCES = (30.0, 60.0)      # [N], in turn
DURATION = 1.0             # [s] of a push
START = (5.0, 9.0)         # [s] from the beginning of a run
LATER = 1.0                # [s] after the push
# Of each push, with so many places.
_TOLD = (('from_vertical', 0), ('plant', 0), ('mass', 1), ('force', 0))
CONTACT = 'contact'        # so a method's words begin where it has told one


def draw_push(robot, plant, seed, force):
    """Return (Case with a push of that force [N] in any direction, its start [s])."""
    rng = np.random.default_rng([seed, 15])
    drawn = draw_case(robot, plant, seed)
    way, start = rng.normal(size=3), float(rng.uniform(*START))
    push = {'name': 'external_contact', 'parameters': {
        'force': force, 'direction': (way / np.linalg.norm(way)).tolist(), 'start': start,
        'duration': DURATION}}
    return Case(plant, seed, drawn.load, drawn.temperature, drawn.speed, hidden=(push,)), start


def measure_push(robot_path, plant, seed, force, learned, methods):
    """
    Return what each method makes of one push.

    {'plant', 'force', 'from_vertical', 'methods': {name: figures}}: angle [deg] between the push
    and straight up or down; mass error [kg] just before the push, RMS during it, LATER after it;
    told: share of the push in which a contact was told; changes: load changes counted in the
    whole run.
    """
    robot, models = robot_and_models(robot_path, plant, functions_of(methods))
    model = models['ours']
    case, start = draw_push(robot, plant, seed, force)
    racing = {**our_contestants(model, chosen_methods(methods), learned,
                                models.get('difference')),
              # It keeps nothing out: what a push does where nobody looks for one.
              OUR_MODEL: Contestant(model, lambda f: LeastSquares(model, True))}
    errors, told, stamps = {name: [] for name in racing}, {name: [] for name in racing}, []
    for sample in case_run(robot, case).samples:
        stamps.append(sample.stamp)
        for name, contestant in racing.items():
            errors[name].append(contestant.update(sample).mean[0] - case.load.mass)
            told[name].append(getattr(contestant.method, 'mismatch', '').startswith(CONTACT))
    figures = {name: {
        **push_figures(np.array(stamps), np.array(errors[name]), np.array(told[name]), start),
        'changes': getattr(contestant.method, 'changes', 0)}
        for name, contestant in racing.items()}
    return {'plant': plant, 'force': force, 'mass': case.load.mass, 'methods': figures,
            'from_vertical': from_vertical(case.hidden[0]['parameters']['direction'])}


def from_vertical(way):
    """Return the angle [deg] between a direction (3,) of length 1 and straight up or down."""
    return float(np.degrees(np.arccos(min(abs(way[2]), 1.0))))


def push_figures(stamps, error, told, start):
    """Return the figures of a push that begins at `start` [s]; stamps, error, told (N,) each."""
    during = (stamps >= start) & (stamps < start + DURATION)
    return {'before': float(error[stamps < start][-1]),
            'during': float(np.sqrt(np.mean(error[during] ** 2))),
            'after': float(error[stamps >= start + DURATION + LATER][0]),
            'told': float(told[during].mean())}


def push_jobs(robot_path, count, learned, methods, development=False):
    """Return {label: arguments} of measure_push."""
    plants = seeds.DEVELOPMENT_PLANTS[50:] if development else seeds.BENCHMARK_PLANTS
    own = seeds.DEVELOPMENT_CASES if development else seeds.BENCHMARK_CASES
    # Behind the seeds of the suggestion suite.
    return {f'push_{plants[k // CASES_PER_PLANT]}_{seed}': (
        robot_path, plants[k // CASES_PER_PLANT], seed, FORCES[k % len(FORCES)], learned, methods)
        for k, seed in enumerate(own[90_000:90_000 + count])}


def push_scores(results):
    """
    Return {'pushes', 'runs', 'methods': {name: figures}} of results by label.

    before, during, after: mass RMSE [kg] over the pushes; worst: the largest during one; told:
    mean share of the push told; changed: runs in which a load change was counted.
    """
    runs = list(results.values())
    return {'pushes': len(runs), 'runs': runs,
            'methods': {name: _over([r['methods'][name] for r in runs])
                        for name in runs[0]['methods']}}


def _over(found):
    rmse = {key: float(np.sqrt(np.mean(np.square([f[key] for f in found]))))
            for key in ('before', 'during', 'after')}
    return {**rmse, 'worst': max(f['during'] for f in found),
            'told': float(np.mean([f['told'] for f in found])),
            'changed': sum(f['changes'] > 0 for f in found)}


def push_blocks(content):
    """Return the blocks of the pushes suite."""
    rows = [[name, *(f'{1e3 * m[key]:.0f}' for key in ('before', 'during', 'worst', 'after')),
             f'{100.0 * m["told"]:.0f}', f'{m["changed"]} of {content["pushes"]}']
            for name, m in content['methods'].items()]
    names = list(content['methods'])
    each = [[*(f'{r[key]:.{places}f}' for key, places in _TOLD), *(
        f'{1e3 * r["methods"][name]["during"]:.0f}, {1e3 * abs(r["methods"][name]["after"]):.0f}'
        for name in names)] for r in sorted(content['runs'], key=lambda r: r['from_vertical'])]
    return [
        Heading('Pushes on the hand', 1),
        Text(f'{content["pushes"]} pushes of {DURATION:g} s in any direction, '
             f'{" or ".join(f"{force:g}" for force in FORCES)} N, while a load is moved. A push '
             'straight up or down is one that a load could make too. '
             f'`{OUR_MODEL}` keeps no contact out.'),
        Table(['method', 'mass RMSE just before [g]', 'during [g]', 'worst push [g]',
               f'{LATER:g} s after [g]', 'told as contact [% of the push]',
               'runs with a load change counted'], rows),
        Table(['from the vertical [deg]', 'plant', 'load [kg]', 'push [N]', *(
            f'{name}: mass error during, after [g]' for name in names)], each)]
