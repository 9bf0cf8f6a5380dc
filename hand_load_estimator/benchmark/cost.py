"""The cost suite: what one sample costs each method, alone in a process of its own."""

from array import array
import time

from .. import seeds
from ..estimators.build import shipped_difference
from ..files.shared_files import find_shared
from ..motion import BLOCK
from ..stream.joint_stream import JointStream
from ..torque.model_file import read_model
from .cases import case_events, draw_case, stream_samples
from .contestants import (chosen_methods, cost_of, ON_FUNCTION, our_contestants,
                          RegressorClock)
from .memory import resident_mib

SAMPLES = 1.0 / BLOCK    # [1/s]
RATES = (500.0, 1000.0)  # [Hz] of joint states, of which the cost is told
# Samples before the clock starts: caches and just-in-time work are no running cost.
_WARM_UP = 50


class TimedStream(JointStream):
    """A JointStream that notes what each joint state takes: guard and filter, no estimate."""

    def __init__(self, robot):
        super().__init__(robot)
        self.times = []

    def joint_state(self, stamp, names, *signals):
        """Take one joint state as a node has it, of floats; return as JointStream does."""
        message = float(stamp), list(names), *(array('d', values) for values in signals)
        began = time.thread_time()
        sample = super().joint_state(*message)
        self.times.append(time.thread_time() - began)
        return sample


def measure_cost(robot_name, method, learned):
    """
    Return the cost of one method on a development case with the model shipped for a robot.

    {'name', 'cost', 'regressor', 'regressor_alone', 'joint_state'}: seconds per 20 ms sample, per
    call of pinocchio's regressor at the same samples, between those of the method and in a loop
    of its own, and per joint state at 500 Hz before any method sees it, each mean, p50, p99;
    'start_mib': memory that building it took; 'growth_mib': that it took from the first second to
    the last.
    """
    model = read_model(find_shared(robot_name, 'models'))
    robot = model.robot
    stream = TimedStream(robot)
    case = draw_case(robot, seeds.SHIPPED_MODEL_PLANT, seeds.DEVELOPMENT_CASES[0])
    samples = list(stream_samples(robot, case_events(robot, case), stream))
    alone = regressor_alone(robot, samples)
    clock, before = RegressorClock(robot), resident_mib()
    racing = our_contestants(model, (method,), learned, {'gp': shipped_difference(model)})
    built, ((ran, contestant),) = resident_mib(), racing.items()
    for k, sample in enumerate(samples):
        clock.update(sample)
        contestant.update(sample)
        if k == _WARM_UP:
            warm = resident_mib()
    return {'name': ran, 'cost': cost_of(contestant.times[_WARM_UP:]),
            'regressor': cost_of(clock.times[_WARM_UP:]), 'regressor_alone': alone,
            'joint_state': cost_of(stream.times[_WARM_UP:]), 'start_mib': built - before,
            'growth_mib': resident_mib() - warm}


def regressor_alone(robot, samples):
    """Return cost_of the regressor call at MotionSamples with nothing between the calls."""
    clock = RegressorClock(robot)
    for sample in samples:
        clock.update(sample)
    return cost_of(clock.times[_WARM_UP:])


def seconds_per_joint_state(content, name, rate):
    """Return the mean [s] of guard, filter and a sample's share, of cost_scores; rate [Hz]."""
    return (content['joint_state'][name]['mean']
            + content['cost'][name]['mean'] * SAMPLES / rate)


def cost_jobs(robot_name, learned, methods):
    """Return {label: arguments} of measure_cost, one per method with something shipped."""
    return {f'cost_{name}': (robot_name, name, learned) for name in chosen_methods(methods)
            if name not in ON_FUNCTION}


def cost_scores(results):
    """
    Return {what: {method: figures}}: seconds of what measure_cost times, 'memory' [MiB], 'is'.

    Each method is compared with the regressor call of its own process, undisturbed; what a method
    leaves in the processor's caches makes that call up to five times as long.
    """
    by_name = {label.removeprefix('cost_'): r for label, r in results.items()}
    return {**{what: {name: r[what] for name, r in by_name.items()}
               for what in ('cost', 'regressor', 'regressor_alone', 'joint_state')},
            'memory': {name: {key: r[key] for key in ('start_mib', 'growth_mib')}
                       for name, r in by_name.items()},
            'is': {name: r['name'] for name, r in by_name.items()}}
