"""The soak suite: a day of joint states through the Pipeline, faster than real time."""

from dataclasses import replace
import json
from pathlib import Path
import time

import numpy as np

from ..estimators.build import build_pipeline
from ..files.whole_file import whole_file
from ..plant import follow_motion, Plant, TemperatureEvent
from ..seeds import SHIPPED_MODEL_PLANT
from ..simulation.simulate_motions import named_motion
from .memory import resident_mib

LOOP = 60.0          # [s] of one simulated loop that is replayed
RATE = 125.0         # [Hz] of its joint states
EPOCH = 1000.0       # [s] first stamp
# The motion goes round so many times before the loop, from about the temperatures [degC] it keeps.
BEFORE, START, AMBIENT = 2, 45.0, 25.0
# What counts as flat: memory from the first tenth on, and the time a message takes. Half an hour
# of the default method gained 0.00 MiB from its second minute on; beside the fixed calculation its
# minutes spread by 10 % on a machine with twice more work than cores, by 25 % without it.
FLAT_MIB, FLAT_TIME = 2.0, 0.15
_POINTS = 200
# The fixed calculation beside it: regressor calls, and messages between them.
UNIT, UNIT_EVERY = 50, 250


def looped_events(robot):
    """
    Return (events, length [s]) of a run with the rated load that ends where it began.

    Also in what friction holds and in temperature: the arm has moved like that before. A standing
    arm whose torque jumps where the loop is closed was given another load.
    """
    motion = named_motion('excite', robot, LOOP, 1.0, SHIPPED_MODEL_PLANT)
    plant = Plant(robot, SHIPPED_MODEL_PLANT, START, AMBIENT, load=robot.rated_load, rate=RATE,
                  start_position=motion.position[0])
    for _ in range(BEFORE + 1):
        events = list(follow_motion(plant, motion.time, motion.position, motion.velocity,
                                    motion.acceleration))
    first = events[0].stamp
    return ([replace(event, stamp=event.stamp - first) for event in events],
            events[-1].stamp - first + 1.0 / RATE)


def replay(pipeline, events, length, hours, before=None, keep=lambda found: None):
    """
    Feed `hours` of looped events to a Pipeline; return what was found.

    rows (stamp [h], RSS [MiB], mean and 99th percentile of the processor time per joint state
    [s], that of a fixed calculation at the same time [s], process), wall clock `seconds` of all,
    loops, the pipeline's counts and `state`. before: what another process found before it was
    broken off, from which this one goes on; keep(found): called with what there is at every row.
    """
    found = before or _NOTHING
    process = found['rows'][-1][-1] + 1 if found['rows'] else 0
    loops = max(int(np.ceil(hours * 3600.0 / length)), 1)
    every = max(loops // _POINTS, 1)
    counts, times, units, began = _counts(pipeline), [], [], time.perf_counter()
    for loop in range(found['loops'], loops):
        _feed(pipeline, events, EPOCH + loop * length, times, units)
        if (loop + 1) % every and loop != loops - 1:
            continue
        now, hour = _counts(pipeline), (loop + 1) * length / 3600.0
        row = [hour, resident_mib(), float(np.mean(times)), float(np.quantile(times, 0.99)),
               float(np.mean(units)), process]
        found = {'rows': [*found['rows'], row], 'hours': hour, 'loops': loop + 1,
                 'seconds': found['seconds'] + time.perf_counter() - began,
                 **{name: found[name] + now[name] - counts[name] for name in counts},
                 'mass': float(pipeline.method.belief().mean[0]),
                 'true_mass': pipeline.model.robot.rated_load.mass, 'state': _state(pipeline)}
        keep(found)
        counts, times, units, began = now, [], [], time.perf_counter()
    return found


def _counts(pipeline):
    return {'samples': pipeline.samples, 'rejected': sum(pipeline.rejected.values()),
            'load_changes': pipeline.load_id}


_NOTHING = {'rows': [], 'loops': 0, 'seconds': 0.0, 'samples': 0, 'rejected': 0,
            'load_changes': 0}


def _state(pipeline):
    """Return {name: (shape, numbers)} of the Pipeline."""
    return {name: (np.shape(value), np.ravel(value).tolist())
            for name, value in pipeline.state().items()}


def _feed(pipeline, events, offset, times, units):
    """Feed events that much later; add processor times [s]: of joint states, of the unit."""
    robot = pipeline.model.robot
    for event in events:
        if isinstance(event, TemperatureEvent):
            for joint, celsius in zip(robot.joints, event.celsius):
                pipeline.temperature_reading(joint, celsius)
            continue
        start = time.thread_time()
        pipeline.joint_state(offset + event.stamp, robot.joints, event.position, event.velocity,
                             event.effort)
        middle = time.thread_time()
        times.append(middle - start)
        if len(times) % UNIT_EVERY == 1:
            # Beside other work the processor itself is slower, for an hour as for a moment.
            for _ in range(UNIT):
                robot.load_regressor(event.position, event.velocity, event.velocity)
            units.append(time.thread_time() - middle)
    pipeline.settle()


def soak_scores(found):
    """Return the figures of a replay: growth of memory, drift of times, both flat or not."""
    rows = np.array(found['rows'])
    drifts = [_drift(rows[:, column] / rows[:, 4]) for column in (2, 3)]
    processes = np.unique(rows[:, 5])
    growth = sum(_growth(rows[rows[:, 5] == process, 1]) for process in processes)
    return {**{name: value for name, value in found.items() if name != 'state'},
            'processes': len(processes), 'growth_mib': growth,
            'time_drift_percent': 100.0 * drifts[0], 'tail_drift_percent': 100.0 * drifts[1],
            'flat_memory': bool(growth < FLAT_MIB), 'flat_time': bool(max(drifts) < FLAT_TIME),
            'times_real_time': 3600.0 * found['hours'] / found['seconds'],
            'microseconds_per_message': 1e6 * float(np.median(rows[:, 2])),
            'microseconds_p99': 1e6 * float(np.median(rows[:, 3]))}


def _growth(memory):
    """Return by how much the last tenth of one process's rows [MiB] is above the first."""
    tenth = max(len(memory) // 10, 1)
    return float(memory[-tenth:].mean() - memory[:tenth].mean())


def _drift(times):
    # Medians: another process on the machine delays single rows.
    fifth = max(len(times) // 5, 1)
    return float(np.median(times[-fifth:]) / np.median(times[:fifth]) - 1.0)


def run_soak(robot_name, method, learned, hours, folder, write):
    """Return soak_scores of a day's replay; its raw file is gone on from if it is there."""
    path = Path(folder) / f'soak_{method}_{hours:g}h.json'
    before = json.loads(path.read_text('utf-8')) if path.exists() else None
    if before is None or before['hours'] < hours - 1e-9:
        pipeline = build_pipeline(robot_name, method, learned)
        if before:
            pipeline.restore({name: np.reshape(numbers, shape)
                              for name, (shape, numbers) in before['state'].items()},
                             'as it was when the soak was broken off')
        events, length = looped_events(pipeline.model.robot)
        began, first = time.monotonic(), before['hours'] if before else 0.0

        def keep(found):
            with whole_file(path) as part:
                part.write_text(json.dumps({**found, 'method': pipeline.method.name}),
                                encoding='utf-8')
            hour = found['hours']
            left = (time.monotonic() - began) * (hours - first) / (hour - first)
            left -= time.monotonic() - began
            write(f'{hour:.1f} of {hours:g} h  {max(left, 0.0) / 60.0:.1f} min left')

        replay(pipeline, events, length, hours, before, keep)
    return soak_scores(json.loads(path.read_text('utf-8')))
