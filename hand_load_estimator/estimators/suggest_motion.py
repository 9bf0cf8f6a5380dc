"""
Suggest the smallest joint motion that would determine what is not determined of the load.

Candidates are there-and-back motions from where the arm stands: of one joint, of two wrist
joints, of all joints behind some point (a joint that stands hides its share of the load behind
friction). What each would tell is summed as the estimator will sum it (information.py): the
load's columns weighted by the torque model's density, less while friction is stuck, with the
model's own uncertainty marginalised, as far as the model is trusted by now. The candidate is taken
that costs least of those that settle most.
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from ..errors import HandLoadError
from ..load import MESSAGE_ORDER, products_jacobian_of_message
from ..motion import BLOCK, MotionSample
from ..motions.excitation_limits import Clearance
from ..motions.trajectory import Trajectory
from ..torque.model_follower import ModelFollower
from ..torque.presliding import PreslidingState, stuck_density
from .information import Information
from .tool import ToolFollower
from .weighting import joined_columns

AMPLITUDES = (0.1, 0.2, 0.4, 0.8, 1.5)   # [rad]
SPEEDS = (0.25, 0.8)         # share of the robot file's velocity limits
_ACCELERATION = 0.7          # share of its acceleration limits
_SHORTEST = 0.4              # [s] one way
_MARGIN = 0.05               # [rad] kept from the position limits
_WRIST = 4                   # joints, counted from the hand, of which two are moved together
_SIGNS = ((1.0,), (-1.0,), (1.0, -1.0), (-1.0, 1.0))  # of many joints moved together, in turn
_COARSE = 8                  # samples one way, of the first look
# A joint that moves the whole arm costs this much more per radian than the last wrist joint.
_WHOLE_ARM = 4.0
_SECOND = 0.5                # cost of one second, beside radians
# A quintic from rest to rest over 1 rad in 1 s reaches these peaks.
_PEAK_SPEED, _PEAK_ACCELERATION = 1.875, 5.7735
# How much better than the threshold the expectation must be: it is one.
_SURELY = 0.8
# Parameters are settled in this order: without mass and place, inertia means little.
_FIRST = slice(0, 4)


class SuggestionError(HandLoadError):
    """No motion can be suggested now; the sentence says why."""


@dataclass(frozen=True)
class Suggestion:
    """
    What is open, and the motion that would settle it.

    undetermined, settled: names of parameters; moves: (joint name, amplitude [rad]) pairs;
    trajectory: from the present pose and back, or None where no motion would help; std (10,):
    expected after it, message order; now (10,): the present one.
    """

    undetermined: tuple
    settled: tuple
    moves: tuple
    trajectory: Trajectory | None
    now: np.ndarray
    std: np.ndarray

    def text(self):
        """Return it in words."""
        if not self.undetermined:
            return 'mass, centre of mass and inertia are determined'
        told = 'not determined: ' + self._stds(self.undetermined, self.now)
        if self.trajectory is None:
            return f'{told}; no motion from here within the limits would settle any of it'
        moves = ' and '.join(f'{joint} by {amplitude:+.2f} rad' for joint, amplitude in self.moves)
        told += f'; move {moves} and back in {self.trajectory.duration:.1f} s; '
        left = [name for name in self.undetermined if name not in self.settled]
        told += f'expected std after it: {self._stds(self.undetermined, self.std)}'
        return told + (f'; not settled by it: {", ".join(left)}' if left else '')

    def _stds(self, names, std):
        return ', '.join(_told(name, std[MESSAGE_ORDER.index(name)]) for name in names)


def _told(name, std):
    if name == 'm':
        return f'mass {std:.3f} kg'
    return f'{name} {1e3 * std:.1f} mm' if name in 'xyz' else f'{name} {std:.4f} kg m^2'


@dataclass(frozen=True)
class _Candidate:
    """Joints, amplitudes [rad], seconds one way, cost."""

    joints: tuple
    amplitudes: tuple
    seconds: float
    cost: float

    def trajectory(self, pose):
        """Return the motion from a pose (n,) and back."""
        far = np.array(pose, dtype=float)
        far[list(self.joints)] += self.amplitudes
        rest = np.zeros((3, len(far)))
        return Trajectory([0.0, self.seconds, 2.0 * self.seconds], [pose, far, pose], rest, rest)


class MotionSuggester:
    """
    Find suggestions for one TorqueModel.

    thresholds (10,): std that counts as determined; tool: the Tool that is held beside the load,
    or None.
    """

    def __init__(self, model, thresholds, tool=None):
        self._model, self._robot, self._thresholds = model, model.robot, np.array(thresholds)
        follower = ModelFollower(model, measured=False)
        self._follower = ToolFollower(follower, tool) if tool else follower
        self._clearance = Clearance(model.robot)
        self._level = model.held_friction()
        self._candidates = sorted(self._all(), key=lambda candidate: candidate.cost)

    def suggest(self, method, pose, temperature):
        """
        Return the Suggestion for what a Method believes of an arm standing at pose (n,) [rad].

        temperature (n,) [degC], NaN: unknown.
        """
        believed = method.belief()
        now = np.sqrt(np.diag(believed.covariance))
        open_ = now >= self._thresholds
        wanted = np.zeros(10, dtype=bool)
        wanted[_FIRST] = open_[_FIRST]
        wanted = wanted if wanted.any() else open_
        best, best_std = (None, now)
        if open_.any():
            self._follower.carry(believed, method)
            belief = _Belief(believed.mean, believed.covariance)
            best, best_std = self._best(belief, method.trusted, (pose, temperature), wanted)
        names = np.array(MESSAGE_ORDER)
        if best is None:
            return Suggestion(tuple(names[open_]), (), (), None, now, now)
        moves = tuple((self._robot.joints[j], a) for j, a in zip(best.joints, best.amplitudes))
        return Suggestion(tuple(names[open_]), tuple(names[open_ & (best_std < self._thresholds)]),
                          moves, best.trajectory(pose), now, best_std)

    def _best(self, belief, trust, standing, wanted):
        """Return the (cheapest _Candidate, its std) that settles all wanted, or most of it."""
        pose, temperature = standing
        best, best_std, best_open = None, None, self._openness(belief.std, wanted)
        for candidate in self._candidates:
            motion = candidate.trajectory(pose)
            if not self._inside(motion):
                continue
            quick = self._openness(belief.after(self._glance(motion, trust)), wanted)
            # A glance flatters: it knows the model's parameters.
            if quick >= best_open - 0.05 or not self._clear(motion, pose):
                continue
            std = belief.after(self._look(motion, temperature, trust))
            found = self._openness(std, wanted)
            if found < best_open - 0.05:
                best, best_std, best_open = candidate, std, found
            if best_open == 0.0:
                break
        return best, best_std

    def _openness(self, std, wanted):
        """Return how far the wanted parameters are from being determined, 0 when all are."""
        ratio = std[wanted] / (_SURELY * self._thresholds[wanted])
        return float(np.sum(np.log(np.maximum(ratio, 1.0))))

    def _all(self):
        n = self._robot.n
        single = [((j,), (sign * a,), speed) for j in range(n) for sign in (1.0, -1.0)
                  for a in AMPLITUDES for speed in SPEEDS]
        double = [(pair, (first * a, second * a), SPEEDS[-1])
                  for pair in combinations(range(max(n - _WRIST, 0), n), 2)
                  for a in AMPLITUDES for first, second in product((1.0, -1.0), repeat=2)]
        more = [(tuple(range(first, n)), tuple(a * np.resize(signs, n - first)), SPEEDS[-1])
                for first in range(n - 2) for a in AMPLITUDES[:-1] for signs in _SIGNS]
        return [self._candidate(*found) for found in single + double + more]

    def _candidate(self, joints, amplitudes, speed):
        size, limits, own = np.abs(amplitudes), self._robot.limits, list(joints)
        seconds = max(_SHORTEST,
                      np.max(_PEAK_SPEED * size / (speed * limits.velocity[own])),
                      np.max(np.sqrt(_PEAK_ACCELERATION * size
                                     / (_ACCELERATION * limits.acceleration[own]))))
        n = self._robot.n
        weight = _WHOLE_ARM ** ((n - 1 - np.array(joints)) / max(n - 1, 1))
        return _Candidate(joints, amplitudes, seconds, float(weight @ size) + _SECOND * seconds)

    def _inside(self, motion):
        """Tell whether position and, with the rated load, torque stay within the limits."""
        limits, far = self._robot.limits, motion.position[1]
        if (far < limits.lower + _MARGIN).any() or (far > limits.upper - _MARGIN).any():
            return False
        samples = motion.sample(np.linspace(0.0, motion.time[1], 7))
        torque = np.array([self._robot.rigid_torque(*row, self._robot.rated_load)
                           for row in zip(*samples)])
        return bool((np.abs(torque) <= limits.allowed_torque * limits.torque).all())

    def _clear(self, motion, pose):
        """Tell whether the arm comes no nearer to floor and base than wanted, or than it is."""
        q, _, _ = motion.sample(np.linspace(0.0, motion.time[1], 5))
        return self._clearance.of(q) >= min(self._clearance.wanted,
                                            self._clearance.of([pose])) - 1e-6

    def _glance(self, motion, trust):
        """Return information (10, 10) about the load if the model's parameters were exact."""
        model, robot = self._model, self._robot
        times = np.linspace(0.0, motion.duration, 2 * _COARSE + 1)[1:]
        dt, matrix = times[1] - times[0], np.zeros((10, 10))
        # Travels of the reference temperature are near enough to rank motions by.
        path = PreslidingState(model.presliding_distance(), model.presliding_plastic())
        path.update(motion.position[0], np.zeros(robot.n), dt)
        for q, v, a in zip(*motion.sample(times)):
            z, doubt = path.update(q, v, dt)
            density = model.residuals.load_share * (
                model.residuals.intensity + stuck_density(z, doubt, v, self._level))
            columns = robot.load_regressor(q, v, a)
            matrix += columns.T @ (columns * (dt / density)[:, None])
        return matrix / trust.factor

    def _look(self, motion, temperature, trust):
        """Return information (10, 10) about the load as the estimator will have it."""
        robot, follower = self._robot, self._follower
        follower.restart()
        total = Information(robot.n, follower.uncertainties)
        zero = np.zeros(robot.n)
        for t in np.arange(0.0, motion.duration, BLOCK):
            q, v, a = motion.sample(t)
            seen = follower.update(MotionSample(t, BLOCK, q, v, a, zero, temperature, False))
            total.add_rows(joined_columns(seen), zero, BLOCK / seen.density)
        return total.load_share(trust)[0]


class _Belief:
    """A belief in message order, to which information about the products is added."""

    def __init__(self, mean, covariance):
        self.std = np.sqrt(np.diag(covariance))
        self._jacobian = products_jacobian_of_message(mean) * self.std
        self._precision = np.linalg.inv(covariance / np.outer(self.std, self.std))

    def after(self, matrix):
        """Return std (10,) once information (10, 10) about the products is added."""
        precision = self._precision + self._jacobian.T @ matrix @ self._jacobian
        return self.std * np.sqrt(np.maximum(np.diag(np.linalg.inv(precision)), 0.0))
