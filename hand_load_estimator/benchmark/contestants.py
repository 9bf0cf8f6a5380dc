"""Who takes part: our methods by name, rivals that run sample by sample; what each costs."""

import time

import numpy as np
import pinocchio as pin

from ..errors import ConfigurationError
from ..estimators.build import build_method
from ..estimators.physical_consistency import published
from ..estimators.registry import DEFAULT, METHODS, ON_DIFFERENCE, with_network
from ..files.shared_files import share_folder
from ..learning.difference_artefact import PREDICTORS
from ..torque.model_follower import ModelFollower
from .cases import untold
from .rivals import FixedLoad, LeastSquares

# The default without what it learned: the recursive Bayesian update alone.
WITHOUT_NETWORK = 'bayes'
BLIND = f'{DEFAULT}, temperatures withheld'
TEXTBOOK = 'least squares, Coulomb + viscous'
TEXTBOOK_CAREFUL = 'the same, standing joints left out'
# What the torque model alone is worth: the textbook's method looking through ours.
OUR_MODEL = 'least squares, our model, standing joints left out'
NOMINAL = 'recursive least squares, nominal model'
FIXED = 'fixed rated load'
# The torque difference learned while a known load is held (E2.5).
KNOWN_LOAD = 'known_load'
# gp_bayes on that, and on the other functions of the difference (E2.6): {contestant: function}.
ON_FUNCTION = {f'gp_bayes_{name}': name for name in (*PREDICTORS, KNOWN_LOAD) if name != 'gp'}
# A network that reads some joints and answers some parameters (E1.5).
SUBSET, SUBSET_OF = 'gru_subset', 'gru'
_SUBSET_FOLDER = 'config/learned/{}_gru_subset'
# A method without a network whose intervals were made true on draws (`hand_load calibrate`), if
# such are shipped for the robot: nobody asked for takes part.
CALIBRATED = '_calibrated'
_INTERVALS_FOLDER = 'config/learned/{}_{}_intervals'
# The function that a method needs learned for its torque model.
FUNCTION = {**dict.fromkeys(sorted(ON_DIFFERENCE), 'gp'), **ON_FUNCTION}
# The whole arm's regressor: the load's columns alone are no call of pinocchio's.
REGRESSOR = 'one pinocchio joint torque regressor call (whole arm)'


def chosen_methods(names=None):
    """Return the names of methods to measure, all by default; raises ConfigurationError."""
    known = (*METHODS, SUBSET, *ON_FUNCTION)
    calibrated = [name + CALIBRATED for name in METHODS if not with_network(name)]
    unknown = [name for name in names or () if name not in (*known, *calibrated)]
    if unknown:
        raise ConfigurationError('--methods', 'are not all known', ','.join(unknown),
                                 ', '.join((*known, *calibrated)))
    return tuple(names or known)


def functions_of(names=None):
    """Return the functions of the torque difference that chosen_methods need, sorted."""
    return tuple(sorted({FUNCTION[name] for name in map(_method, chosen_methods(names))
                         if name in FUNCTION}))


def _method(name):
    return name.removesuffix(CALIBRATED)


class Contestant:
    """
    A method with the torque model it looks through.

    blind: temperatures are withheld from both. times: what each sample took [s of processor
    time: other work on the machine does not count]. mismatches: samples after which the method
    said that torques and model do not fit.
    """

    def __init__(self, model, method, blind=False):
        self._follower = ModelFollower(model) if model is not None else None
        self._blind, self.times, self.mismatches = blind, [], 0
        self.method = method(self._follower)

    def update(self, sample):
        """Take one MotionSample; return the Belief."""
        began = time.thread_time()
        if self._blind:
            sample = untold(sample)
        prediction = self._follower.update(sample) if self._follower else None
        belief = self.method.update(sample, prediction)
        # What ours believe is carried, and they are judged as they are published; rivals, which
        # know no tare, as they are.
        if hasattr(self.method, 'tared'):
            if self._follower:
                self._follower.carry(belief, self.method)
            belief = published(belief, self.method)
        self.times.append(time.thread_time() - began)
        self.mismatches += bool(getattr(self.method, 'mismatch', ''))
        return belief


def our_contestants(model, names, learned, difference=None):
    """
    Return {name: Contestant} of our methods on a TorqueModel.

    learned: artefact of the default method, or None for the shipped one; difference: {function:
    folder} of the torque difference learned for this model, without which the methods on one stay
    out. A method without an artefact for this robot falls back on another: it stands once, under
    the name of that; SUBSET, which none can stand for, stays out, and so does what is CALIBRATED
    where no intervals are shipped.
    """
    out = {}
    for name in names:
        how = _build_arguments(model.robot, name, learned, difference or {})
        if how is None:
            continue
        contestant = Contestant(model, lambda f, a=how: build_method(model, f.uncertainties, *a))
        ran = contestant.method.name
        out.setdefault(name if ran == how[0] else ran, contestant)
    return out


def _build_arguments(robot, name, learned, difference):
    """Return method, artefact and intervals of a name, or None where it takes no part."""
    method, intervals = _method(name), None
    if name == SUBSET:
        folder = share_folder() / _SUBSET_FOLDER.format(robot.name)
        return (SUBSET_OF, folder, None) if folder.is_dir() else None
    function = FUNCTION.get(method)
    if function and function not in difference:
        return None
    if name != method:
        intervals = share_folder() / _INTERVALS_FOLDER.format(robot.name, method)
        if not intervals.is_dir():
            return None
    own = difference[function] if function else learned if name == DEFAULT else None
    return 'gp_bayes' if name in ON_FUNCTION else method, own, intervals


def contestants(robot, models, names, learned, told=True):
    """
    Return {name: Contestant}, fresh for one case: ours and the baselines.

    told: whether there are temperatures that may be withheld from one.
    """
    ours, textbook, nominal = models['ours'], models['textbook'], models['nominal']
    out = our_contestants(ours, names, learned, models.get('difference'))
    if told and DEFAULT in out:
        out[BLIND] = Contestant(
            ours, lambda f: build_method(ours, f.uncertainties, DEFAULT, learned), blind=True)
    return {
        **out,
        TEXTBOOK: Contestant(textbook, lambda f: LeastSquares(textbook, skip_standing=False)),
        TEXTBOOK_CAREFUL: Contestant(
            textbook, lambda f: LeastSquares(textbook, skip_standing=True)),
        OUR_MODEL: Contestant(ours, lambda f: LeastSquares(ours, skip_standing=True)),
        NOMINAL: Contestant(nominal, lambda f: LeastSquares(nominal, skip_standing=False)),
        FIXED: Contestant(None, lambda f: FixedLoad(robot))}


class RegressorClock:
    """What one call of pinocchio's joint torque regressor takes here: the unit of every cost."""

    def __init__(self, robot):
        self._model, self._data = robot.model, robot.model.createData()
        self.times = []

    def update(self, sample):
        """Time one call at a MotionSample."""
        began = time.thread_time()
        pin.computeJointTorqueRegressor(self._model, self._data, sample.q, sample.v, sample.a)
        self.times.append(time.thread_time() - began)


def cost_of(times):
    """Return mean, median and 99th percentile [s] of what samples took, the first one left out."""
    times = np.asarray(times[1:] or [0.0])
    return {'mean': float(times.mean()), 'p50': float(np.median(times)),
            'p99': float(np.quantile(times, 0.99))}
