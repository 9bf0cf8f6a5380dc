"""The changes suite: loads picked up, exchanged, dropped and slipped, and long running without."""

import numpy as np

from .. import seeds
from ..load import LoadParameters
from ..plant import simulate_motion
from ..simulation.simulate_motions import named_motion
from .cases import draw_load, motion_start, stream_samples
from .change_bound import earliest_seen
from .contestants import chosen_methods, functions_of, our_contestants
from .measure import robot_and_models
from .suites import CASES_PER_PLANT

KINDS = ('pick', 'exchange', 'drop', 'slip')
CHANGES = 40              # unless told
DURATION = 14.0           # [s] of a run with a change
CHANGE_AT = (5.0, 8.0)    # [s] from its start
# A slip that counts: mass times shift [kg m], for a rated load of 12.5 kg.
SLIP = (0.1, 0.3)
LEAST_MASS = 1.0          # [kg] of a load that is picked up, dropped or exchanged; likewise
PLANTS = 10
RUNNING = 1800.0          # [s] of one run without a change, cold at its start
COLD = 15.0               # [degC]


def draw_change(robot, seed, kind):
    """Return (load before, load after, time of the change [s]) of a seed."""
    rng = np.random.default_rng([seed, 11])
    scale = robot.rated_load.mass / 12.5
    first, second = (draw_load(robot, rng, (LEAST_MASS, 10.0)) for _ in range(2))
    at, empty = float(rng.uniform(*CHANGE_AT)), LoadParameters()
    if kind == 'slip':
        way = rng.normal(size=3)
        way *= rng.uniform(*SLIP) * scale / (first.mass * np.linalg.norm(way))
        second = LoadParameters(first.mass, first.com + way, first.inertia)
    return {'pick': (empty, first, at), 'drop': (first, empty, at)}.get(kind, (first, second, at))


def measure_change(robot_path, plant, seed, kind, learned, methods):
    """
    Return when each method saw one change of the load.

    {'kind', 'at', 'moved', 'earliest', 'load', 'rated', 'seen': {method: stamps},
    'end': {method: [mean, std]}}: time of the change and of the first motion after it [s] of a
    joint that carries the load, None where there is none; earliest_seen; the load (10,) held at
    the end, the rated mass [kg], and what each method says at the end.
    """
    robot, models = robot_and_models(robot_path, plant, functions_of(methods))
    before, after, at = draw_change(robot, seed, kind)
    rng = np.random.default_rng([seed, 12])
    motion = named_motion('pick_place', robot, DURATION, rng.uniform(0.5, 1.0), seed)
    events = list(simulate_motion(
        robot, motion.time, motion.position, motion.velocity, motion.acceleration, seed=plant,
        run=seed, start_temperature=rng.uniform(15.0, 50.0), load=before,
        load_changes=[(at, after)]))
    samples = list(stream_samples(robot, events))
    racing = our_contestants(models['ours'], chosen_methods(methods), learned,
                             models.get('difference'))
    told = {name: changes_seen(contestant, samples) for name, contestant in racing.items()}
    moved = motion_start(robot, [e for e in events if e.stamp >= at])
    earliest = earliest_seen(models['ours'], samples, at,
                             after.to_products() - before.to_products())
    return {'kind': kind, 'plant': plant, 'at': at, 'moved': moved, 'earliest': earliest,
            'load': after.to_message().tolist(), 'rated': robot.rated_load.mass,
            'seen': {name: stamps for name, (stamps, _) in told.items()},
            'end': {name: [belief.mean.tolist(), np.sqrt(np.diag(belief.covariance)).tolist()]
                    for name, (_, belief) in told.items()}}


def changes_seen(contestant, samples):
    """Return stamps [s] after which a Contestant counts one more change, and its last Belief."""
    stamps, count = [], 0
    for sample in samples:
        belief = contestant.update(sample)
        if contestant.method.changes > count:
            count = contestant.method.changes
            stamps.append(sample.stamp)
    return stamps, belief


def measure_running(robot_path, plant, seed, seconds, learned, methods):
    """
    Return the changes that each method saw while a load stayed, from a cold start on.

    'end': {method: [error, std]} of the mass [kg] after all that time.
    """
    robot, models = robot_and_models(robot_path, plant, functions_of(methods))
    load = draw_load(robot, np.random.default_rng([seed, 13]))
    motion = named_motion('pick_place', robot, seconds, 1.0, seed)
    events = simulate_motion(
        robot, motion.time, motion.position, motion.velocity, motion.acceleration, seed=plant,
        run=seed, start_temperature=COLD, load=load)
    racing = our_contestants(models['ours'], chosen_methods(methods), learned,
                             models.get('difference'))
    count = 0
    # Not kept: half an hour of samples is not small.
    for count, sample in enumerate(stream_samples(robot, events), start=1):
        beliefs = {name: contestant.update(sample) for name, contestant in racing.items()}
    return {'plant': plant, 'seconds': seconds, 'samples': count,
            'changes': {name: c.method.changes for name, c in racing.items()},
            'end': {name: [float(b.mean[0] - load.mass), float(np.sqrt(b.covariance[0, 0]))]
                    for name, b in beliefs.items()},
            'mismatch': {name: c.mismatches / max(count, 1) for name, c in racing.items()}}


def change_jobs(robot_path, count, hours, learned, methods, development=False):
    """
    Return {label: arguments of measure_job} of `count` changes and `hours` of running.

    Every plant meets every kind; running goes in parts of half an hour, each cold at its start.
    More changes than CHANGES are on other seeds, of arms enough.
    """
    plants = seeds.DEVELOPMENT_PLANTS[50:] if development else seeds.BENCHMARK_PLANTS
    # Behind the accuracy suites' and the effects suite's seeds.
    own = (seeds.DEVELOPMENT_CASES if development else seeds.BENCHMARK_CASES)[70_000:]
    many = min(PLANTS, -(-count // CASES_PER_PLANT))
    if count > CHANGES and not development:
        plants, own = seeds.FINAL_CHANGE_PLANTS, seeds.FINAL_CHANGE_CASES
        many = min(len(plants), -(-count // CASES_PER_PLANT))
    each, jobs = -(-count // many), {}
    for k in range(count):
        plant = plants[k // each]
        jobs[f'change_{plant}_{own[k]}'] = ('change', robot_path, plant, own[k],
                                            KINDS[k % len(KINDS)], learned, methods)
    for k in range(int(np.ceil(hours * 3600.0 / RUNNING - 1e-9))):
        seconds = min(RUNNING, hours * 3600.0 - k * RUNNING)
        plant, seed = plants[k % many], own[count + k]
        jobs[f'running_{plant}_{seed}'] = ('running', robot_path, plant, seed, seconds, learned,
                                           methods)
    return jobs


def measure_job(kind, *arguments):
    """Return the result of one of change_jobs."""
    return (measure_change if kind == 'change' else measure_running)(*arguments)
