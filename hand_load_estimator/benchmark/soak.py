"""The soak suite: a day of joint states through the Pipeline, faster than real time."""

import json
from pathlib import Path
import time

import numpy as np

from ..estimators.build import build_pipeline
from ..plant import simulate_motion, TemperatureEvent
from ..seeds import SHIPPED_MODEL_PLANT
from ..simulate_motions import named_motion
from ..whole_file import whole_file
from .memory import resident_mib

LOOP = 60.0          # [s] of one simulated loop that is replayed
RATE = 125.0         # [Hz] of its joint states
EPOCH = 1000.0       # [s] first stamp
# What counts as flat: memory from the first tenth on, and the time a message takes.
FLAT_MIB, FLAT_TIME = 20.0, 0.2
_POINTS = 200


def looped_events(robot):
    """Return (events, length [s]) of a run with the rated load that ends where it began."""
    motion = named_motion('excite', robot, LOOP, 1.0, SHIPPED_MODEL_PLANT)
    events = list(simulate_motion(
        robot, motion.time, motion.position, motion.velocity, motion.acceleration,
        seed=SHIPPED_MODEL_PLANT, load=robot.rated_load, rate=RATE, start_temperature=35.0))
    return events, events[-1].stamp + 1.0 / RATE


def replay(pipeline, events, length, hours, told=lambda hour: None):
    """
    Feed `hours` of looped events to a Pipeline.

    Returns rows (stamp [h], RSS [MiB], mean seconds of processor time per joint state), wall
    clock `seconds` of all, and the pipeline's counts. told(hour): called with progress.
    """
    robot, rows = pipeline.model.robot, []
    loops = max(int(np.ceil(hours * 3600.0 / length)), 1)
    every = max(loops // _POINTS, 1)
    began, messages, spent = time.perf_counter(), 0, 0.0
    for loop in range(loops):
        offset = EPOCH + loop * length
        start = time.thread_time()
        count = _feed(pipeline, robot, events, offset)
        spent += time.thread_time() - start
        messages += count
        if (loop + 1) % every == 0 or loop == loops - 1:
            hour = (loop + 1) * length / 3600.0
            rows.append([hour, resident_mib(), spent / max(messages, 1)])
            messages, spent = 0, 0.0
            told(hour)
    return {'rows': rows, 'hours': loops * length / 3600.0,
            'seconds': time.perf_counter() - began, 'samples': pipeline.samples,
            'rejected': pipeline.rejected, 'load_changes': pipeline.load_id,
            'mass': float(pipeline.method.belief().mean[0]),
            'true_mass': robot.rated_load.mass}


def _feed(pipeline, robot, events, offset):
    count = 0
    for event in events:
        if isinstance(event, TemperatureEvent):
            for joint, celsius in zip(robot.joints, event.celsius):
                pipeline.temperature_reading(joint, celsius)
            continue
        pipeline.joint_state(offset + event.stamp, robot.joints, event.position, event.velocity,
                             event.effort)
        count += 1
    pipeline.settle()
    return count


def soak_scores(found):
    """Return the figures of a replay: growth of memory, drift of time, both flat or not."""
    rows = np.array(found['rows'])
    tenth = max(len(rows) // 10, 1)
    growth = float(rows[-tenth:, 1].mean() - rows[:tenth, 1].mean()) if len(rows) > 1 else 0.0
    # Medians: another process on the machine delays single rows.
    first, last = np.median(rows[:2 * tenth, 2]), np.median(rows[-2 * tenth:, 2])
    drift = float(last / first - 1.0)
    return {**found, 'growth_mib': growth, 'time_drift_percent': 100.0 * drift,
            'flat_memory': bool(growth < FLAT_MIB), 'flat_time': bool(drift < FLAT_TIME),
            'times_real_time': 3600.0 * found['hours'] / found['seconds'],
            'microseconds_per_message': 1e6 * float(np.median(rows[:, 2]))}


def run_soak(robot_name, method, learned, hours, folder, write):
    """Return soak_scores of a day's replay; its raw file is read if it is there."""
    path = Path(folder) / f'soak_{method}_{hours:g}h.json'
    if not path.exists():
        pipeline = build_pipeline(robot_name, method, learned)
        events, length = looped_events(pipeline.model.robot)
        began = time.monotonic()

        def told(hour):
            left = (time.monotonic() - began) * (hours / hour - 1.0)
            write(f'{hour:.1f} of {hours:g} h  {max(left, 0.0) / 60.0:.1f} min left')

        found = replay(pipeline, events, length, hours, told)
        with whole_file(path) as part:
            part.write_text(json.dumps({**found, 'method': pipeline.method.name}),
                            encoding='utf-8')
    return soak_scores(json.loads(path.read_text('utf-8')))
