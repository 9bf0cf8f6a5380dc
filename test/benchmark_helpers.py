"""Results of benchmark cases made by hand."""

from core_helpers import block

from hand_load_estimator.benchmark.measure import MOMENTS

METHODS = ('lstm', 'bayes', 'least squares')


def result(plant, seed, mass=5.0, off=0.0, std=1.0, bound=0.5, times=len(MOMENTS), changes=0):
    """
    Return a case in which every figure is off by `off` standard figures.

    The bound that does not know friction's start is twice the other.
    """
    load = block(mass).to_message()
    row = [(load + off).tolist(), [std] * 10]
    return {'plant': plant, 'seed': seed, 'load': load.tolist(), 'temperature': 20.0,
            'speed': 1.0, 'bound': [[bound] * 10] * times, 'changes': changes,
            'bound_start_unknown': [[2.0 * bound] * 10] * times,
            'methods': {name: [row] * times for name in METHODS},
            'seconds_per_sample': dict.fromkeys(METHODS, 1e-3 * seed)}
