"""The suggestion suite: what following the suggested motion gains over an ordinary move."""

import numpy as np

from .. import seeds
from ..estimators.build import build_method, determined_std
from ..estimators.pipeline import Pipeline
from ..estimators.suggest_motion import SuggestionError
from ..load import MESSAGE_ORDER
from ..motions.trajectory import Trajectory
from ..plant import Plant
from ..simulation.simulate_motions import named_motion
from ..torque.model_follower import ModelFollower
from .cases import draw_load, HEAVIEST, TEMPERATURES
from .contestants import DEFAULT
from .document import Heading, Table, Text
from .measure import robot_and_models
from .scores import NORMAL_95
from .suites import CASES_PER_PLANT

CASES = 40
ASKED = 1.5           # [s] the arm stands before it moves
LENGTH = 8.0          # [s] watched from then on
PAUSE = 0.3           # [s] the arm stands before it is asked for the next motion
LEAST_MASS = 2.0      # [kg] of a load, for a rated load of 12.5 kg: lighter ones have no place
# Settled: from here on mass (share of the load's) and place [m] err less.
MASS_SHARE, PLACE = 0.02, 0.003
_TEMPERATURES_EVERY = 50   # sensor periods


def measure_suggestion(robot_path, plant, seed, method, learned):
    """
    Return how soon a method settles one load by suggested motions, and by an ordinary move.

    {'plant', 'mass', 'suggested', 'ordinary': {'settled', 'away', 'motions'}}: seconds after the
    arm was told to move until mass and place are right for good, or None; the farthest [rad] a
    joint went until then; how many motions were asked for.
    """
    robot, models = robot_and_models(robot_path, plant, ())
    rng = np.random.default_rng([seed, 14])
    load = draw_load(robot, rng, (LEAST_MASS, HEAVIEST))
    celsius = float(rng.uniform(*TEMPERATURES))
    # Longer than it is watched: it never runs out of moves.
    motion = named_motion('pick_place', robot, 2.0 * LENGTH, 1.0, seed)
    out = {'plant': plant, 'mass': load.mass}
    for name in ('suggested', 'ordinary'):
        pipeline = _pipeline(models['ours'], method, learned)
        arm = Plant(robot, seed=plant, run=seed, start_temperature=celsius, load=load,
                    start_position=motion.position[0])
        wanted = _suggestions(pipeline) if name == 'suggested' else iter([_without_hold(motion)])
        rows, motions = _lead(arm, pipeline, wanted)
        out[name] = {**settled(rows, MASS_SHARE * load.mass), 'motions': motions}
    return out


def _pipeline(model, method, learned):
    follower = ModelFollower(model)
    own = learned if method == DEFAULT else None
    # The place is determined where it is as well known as it is judged here.
    mass, _, inertia = determined_std(model.robot)
    return Pipeline(model, follower, build_method(model, follower.uncertainties, method, own),
                    (mass, PLACE / NORMAL_95, inertia))


def _without_hold(motion):
    """Return a pick-and-place Trajectory from its first move on."""
    return Trajectory(motion.time[1:] - motion.time[1], motion.position[1:], motion.velocity[1:],
                      motion.acceleration[1:])


def _suggestions(pipeline):
    """Yield suggested Trajectories (None: ask again later) until mass and place are determined."""
    while True:
        try:
            suggestion = pipeline.suggest_motion(pipeline.last_stamp)
        except SuggestionError:
            yield None
            continue
        if set(MESSAGE_ORDER[:4]).isdisjoint(suggestion.undetermined):
            return
        yield suggestion.trajectory


def _lead(arm, pipeline, wanted):
    """
    Lead a Plant along the motions wanted, one after the other.

    Return rows (seconds since asked, mass error [kg], place error [m], way of the joint farthest
    from its start [rad]) and the number of motions.
    """
    robot, load, began = arm.robot, arm.true_load, arm.state()[0]
    rows, motions, due, k = [], 0, ASKED, 0
    while arm.time < ASKED + LENGTH:
        if arm.moving:
            due = arm.time + PAUSE
        elif arm.time >= due:
            due = arm.time + PAUSE
            motion = next(wanted, None)
            if motion is not None:
                motions += 1
                arm.set_trajectory(robot.joints, motion.time, motion.position, motion.velocity,
                                   motion.acceleration)
        if k % _TEMPERATURES_EVERY == 0:
            for joint, celsius in zip(robot.joints, arm.measure_temperatures()):
                pipeline.temperature_reading(joint, celsius)
        arm.step()
        k += 1
        estimate = pipeline.joint_state(arm.time, robot.joints, *arm.measure())
        if estimate is not None and arm.time >= ASKED:
            rows.append((arm.time - ASKED, abs(estimate.mean[0] - load.mass),
                         float(np.linalg.norm(estimate.mean[1:4] - load.com)),
                         float(np.abs(arm.state()[0] - began).max())))
    return rows, motions


def settled(rows, mass):
    """Return {'settled', 'away'} of rows as of measure_suggestion; mass [kg] may be missed by."""
    time, mass_error, place_error, away = np.array(rows).T
    outside = np.flatnonzero((mass_error > mass) | (place_error > PLACE))
    first = outside[-1] + 1 if len(outside) else 0
    if first == len(time):
        return {'settled': None, 'away': float(away.max())}
    return {'settled': float(time[first]), 'away': float(away[:first + 1].max())}


def suggestion_jobs(robot_path, count, method, learned, development=False):
    """Return {label: arguments} of measure_suggestion."""
    plants = seeds.DEVELOPMENT_PLANTS[50:] if development else seeds.BENCHMARK_PLANTS
    own = seeds.DEVELOPMENT_CASES if development else seeds.BENCHMARK_CASES
    # Behind the seeds of the changes suite.
    return {f'suggestion_{plants[k // CASES_PER_PLANT]}_{seed}': (
        robot_path, plants[k // CASES_PER_PLANT], seed, method, learned)
        for k, seed in enumerate(own[80_000:80_000 + count])}


def suggestion_scores(results, method):
    """
    Return {'method', 'cases', 'sooner', 'suggested', 'ordinary': figures} of results by label.

    sooner: cases settled sooner by suggested motions; median [s] over all cases, infinite where
    half are not settled; settled: how many are; away: median [rad].
    """
    runs = list(results.values())
    time = {name: np.array([np.inf if r[name]['settled'] is None else r[name]['settled']
                            for r in runs]) for name in ('suggested', 'ordinary')}
    return {'method': method, 'cases': len(runs), 'runs': runs,
            'sooner': int((time['suggested'] < time['ordinary']).sum()),
            **{name: {'median': float(np.median(found)), 'settled': int(np.isfinite(found).sum()),
                      'away': float(np.median([r[name]['away'] for r in runs]))}
               for name, found in time.items()}}


def suggestion_blocks(content):
    """Return the blocks of the suggestion suite."""
    rows = [[what, _seconds(content[name]['median']),
             f'{content[name]["settled"]} of {content["cases"]}', f'{content[name]["away"]:.2f}']
            for name, what in (('suggested', 'suggested motions'),
                               ('ordinary', 'ordinary moves of all joints'))]
    each = [[str(r['plant']), f'{r["mass"]:.1f}', *(
        _seconds(r[name]['settled']) for name in ('suggested', 'ordinary')),
        str(r['suggested']['motions'])] for r in content['runs']]
    return [
        Heading('Following the suggested motion', 1),
        Text(f'`{content["method"]}` on an arm that has stood for {ASKED:g} s with a load of '
             f'{LEAST_MASS:g} kg or more: once it follows what is suggested, and asks again where '
             f'the 95 % interval of the place is wider than {1e3 * PLACE:g} mm, once it goes on '
             'with pick and place at full speed. Time from the order to move until the mass errs '
             f'by less than {100.0 * MASS_SHARE:g} % of the load\'s and the place by less than '
             f'{1e3 * PLACE:g} mm, for good within {LENGTH:g} s. Sooner by suggested motions: '
             f'{content["sooner"]} of {content["cases"]}.'),
        Table(['', 'median time [s]', 'settled', 'farthest joint until then, median [rad]'], rows),
        Table(['plant', 'load [kg]', 'suggested [s]', 'ordinary [s]', 'motions suggested'], each)]


def _seconds(value):
    return '-' if value is None or not np.isfinite(value) else f'{value:.2f}'
