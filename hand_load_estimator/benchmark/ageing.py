"""The ageing suite: whether the residual watch tells at work that the torque model has aged."""

import numpy as np

from .. import seeds
from ..errors import ConfigurationError
from ..estimators.build import build_method, determined_std
from ..estimators.pipeline import Pipeline
from ..estimators.residual_watch import ENOUGH
from ..plant import TemperatureEvent
from ..plant.effects_file import parse_effects
from ..plant.hidden import EFFECTS
from ..simulation.simulate_motions import named_motion
from ..torque.model_follower import ModelFollower
from .cases import draw_case, motion_events
from .document import Heading, Table, Text
from .effect_cases import EffectCase, FROM_OUTSIDE, Hidden, place, SINGLE
from .measure import robot_and_models
from .share import share_text
from .suites import CASES_PER_PLANT

DURATION = 120.0           # [s] of pick-and-place in which the watch has to tell
STRENGTHS = (2.0, 5.0)
CLEAN = 20                 # runs in which nothing has aged
# What comes from outside, or hangs on the hand, is nothing of the arm's that has aged.
AGEING = tuple(name for name in EFFECTS if name not in (*FROM_OUTSIDE, 'swinging_load'))
_CASES = (*((name, strength) for strength in STRENGTHS for name in AGEING),
          *((None, 0.0),) * CLEAN)


def measure_ageing(robot_path, plant, seed, name, strength, learned, method):
    """
    Return what the watch told of an arm with one effect since its identification, or none.

    {'effect', 'strength', 'joints', 'first'}: the joints it acts on, empty for the whole arm;
    first: [seconds from the start, joint] when a joint was told first, or None. `skipped`: why
    no joint can have the effect so strong.
    """
    robot, models = robot_and_models(robot_path, plant, ())
    drawn = draw_case(robot, plant, seed)
    told = {'plant': plant, 'effect': name, 'strength': strength}
    try:
        entries = _entries(robot, plant, seed, name, strength)
    except ConfigurationError as error:
        return {**told, 'skipped': str(error)}
    follower = ModelFollower(models['ours'])
    pipeline = Pipeline(models['ours'], follower, build_method(
        models['ours'], follower.uncertainties, method, learned), determined_std(robot))
    motion = named_motion('pick_place', robot, DURATION, drawn.speed, seed)
    first = None
    for event in motion_events(robot, motion, seed=plant, run=seed, load=drawn.load,
                               start_temperature=drawn.temperature,
                               effects=parse_effects(entries, robot)):
        if isinstance(event, TemperatureEvent):
            for joint, celsius in zip(robot.joints, event.celsius):
                pipeline.temperature_reading(joint, celsius)
            continue
        pipeline.joint_state(event.stamp, robot.joints, event.position, event.velocity,
                             event.effort)
        if first is None and (aged := pipeline.watch.aged):
            first = [event.stamp - motion.time[0], aged[0].joint]
    return {**told, 'joints': [joint for entry in entries for joint in entry.get('joints', ())],
            'first': first}


def _entries(robot, plant, seed, name, strength):
    if name is None:
        return []
    joints = np.random.default_rng([seed, 21]).permutation(robot.n).tolist()
    hidden = Hidden(name, strength, tuple(joints) if EFFECTS[name].per_joint else ())
    return place(robot, EffectCase(SINGLE, plant, (hidden,)))


def ageing_jobs(robot_path, count, method, learned, development=False):
    """Return {label: arguments} of measure_ageing: `count` of all cases, None for all."""
    plants = seeds.DEVELOPMENT_PLANTS[50:] if development else seeds.BENCHMARK_PLANTS
    own = seeds.DEVELOPMENT_CASES if development else seeds.BENCHMARK_CASES
    # Behind the seeds of the pushes suite; mixed, so that few cases have some of everything.
    order = np.random.default_rng(22).permutation(len(_CASES))[:count]
    return {f'ageing_{plants[k // CASES_PER_PLANT]}_{seed}': (
        robot_path, plants[k // CASES_PER_PLANT], seed, *_CASES[case], learned, method)
        for k, (seed, case) in enumerate(zip(own[95_000:], order))}


def ageing_scores(results, method):
    """
    Return {'method', 'effects', 'clean', 'skipped', 'all'} of results by label.

    effects: a row per effect and strength; clean: [runs, those in which a joint was told, hours];
    all: the rows of one strength together.
    """
    runs = [r for r in results.values() if 'skipped' not in r]
    clean = [r for r in runs if r['effect'] is None]
    aged = [r for r in runs if r['effect'] is not None]
    groups = sorted({(r['effect'], r['strength']) for r in aged})
    return {'method': method,
            'effects': [_row(*group, [r for r in aged if (r['effect'], r['strength']) == group])
                        for group in groups],
            'all': [_row('all', strength, those) for strength in STRENGTHS
                    if (those := [r for r in aged if r['strength'] == strength])],
            'clean': [len(clean), sum(r['first'] is not None for r in clean),
                      len(clean) * DURATION / 3600.0],
            'skipped': [f'{r["effect"]} ({r["strength"]:g})' for r in results.values()
                        if 'skipped' in r]}


def _row(name, strength, runs):
    told = [r for r in runs if r['first'] is not None]
    own = [r for r in told if r['joints']]
    return {'effect': name, 'strength': strength, 'runs': len(runs), 'told': len(told),
            'own': len(own), 'right': sum(r['first'][1] in r['joints'] for r in own),
            'seconds': float(np.median([r['first'][0] for r in told])) if told else None}


def ageing_blocks(content):
    """Return the blocks of the ageing suite."""
    runs, false, hours = content['clean']
    rows = [[_name(row), f'{row["strength"]:g}', f'{row["told"]} of {row["runs"]}',
             f'{row["right"]} of {row["own"]}' if row['own'] else '-',
             '-' if row['seconds'] is None else f'{row["seconds"]:.0f}']
            for row in (*content['all'], *content['effects'])]
    skipped = f' Not possible in the arm: {", ".join(content["skipped"])}.' \
        if content['skipped'] else ''
    return [
        Heading('An aged model told at work', 1),
        Text(f'Pick and place for {DURATION:g} s with a load that nobody states, estimated by '
             f'`{content["method"]}`, on arms to which one effect happened since their '
             'identification; strength: RMS torque of the effect over the noise along the '
             'reference motion of the effects file, not along this one. What `/diagnostics` says '
             'on the way: whether a joint was told to have a residual above what the model '
             'states, whether the first one told was the one with the effect (of effects of '
             f'single joints), and when; never before a joint has slid for {ENOUGH:g} s. Medians '
             'are of the runs in which one was told.' + skipped),
        Text(f'False alarms: in {share_text(false, runs)} of the runs of arms that are as '
             f'identified, {hours:.2f} h together.') if runs else Text('No run without effect.'),
        Table(['effect', 'strength', 'told', 'first joint right', 'after, median [s]'], rows)]


def _name(row):
    return row['effect'] if row['effect'] == 'all' else f'`{row["effect"]}`'
