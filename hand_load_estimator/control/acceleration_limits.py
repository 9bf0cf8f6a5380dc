"""
Shortest acceleration and deceleration times the joint torques allow (rows E8.1 to E8.3).

The equation of motion is evaluated at the four points of E8.1 (acceleration start and end,
deceleration start and end: the knots of the profile) and at points between them.
"""

from dataclasses import dataclass, replace

import numpy as np

from .load_belief import LoadBelief, rated_belief
from .planned_move import PlannedMove
from .profile import PathLimits, make_profile
from .torque_use import TorqueUse

_SPEED_SHARES = (1.0, 0.7, 0.5, 0.35, 0.25)
_SMALLEST = 0.02            # share of the configured acceleration below which nothing is gained
_SLOW = 0.1                 # share used when no acceleration keeps the torques
_BISECTIONS = 9             # 0.02 ** (1 / 2 ** 9): limits to better than 1 %
_SHRINK = (1.0, 0.95, 0.85, 0.7)


@dataclass(frozen=True)
class PlanSettings:
    """
    How cautiously moves are planned.

    sigma: standard deviations of the load's torque added on the safe side; rise_time [s]: in
    which the configured acceleration builds up; speed_scale: share of the configured velocity
    in (0, 1].
    """

    sigma: float = 3.0
    rise_time: float = 0.1
    speed_scale: float = 1.0


def _largest(allowed, high):
    """Return the largest value up to high that is allowed; None when the smallest is not."""
    if allowed(high):
        return high
    low = _SMALLEST * high
    if not allowed(low):
        return None
    for _ in range(_BISECTIONS):
        middle = np.sqrt(low * high)
        if allowed(middle):
            low = middle
        else:
            high = middle
    return low


class MovePlanner:
    """Plans moves of one robot: model is a TorqueSource."""

    def __init__(self, model, settings=PlanSettings()):
        self._model, self._settings = model, settings
        self._limits = model.robot.limits
        self._rated = rated_belief(model.robot)

    def plan(self, start, goal, belief, temperature, caution=0.0):
        """
        Return the PlannedMove from start to goal (n,) [rad].

        belief: LoadBelief; temperature (n,) [degC]; caution in [0, 1]: 0 uses all the belief
        allows, 1 only what the rated load allows too.
        """
        line = _Line(np.array(start, dtype=float), np.array(goal, dtype=float), self._top)
        return self._fastest(line, belief, temperature, caution) or self._slow(line, belief)

    def rest(self, move, elapsed, belief, temperature, caution=0.0):
        """
        Return the move's rest from `elapsed` [s] on, planned anew for the belief (E8.2).

        None when the path left is too short to stop with the torque allowed: then the move as
        planned is the better one.
        """
        state = tuple(float(x[0]) for x in move.profile.sample(np.array([elapsed])))
        line = _Line(move.start, move.goal, self._top, state)
        return self._fastest(line, belief, temperature, caution)

    def use(self, move, belief, temperature, since=0.0):
        """Return the largest share of the allowed torque from `since` [s] to the move's end."""
        times = np.linspace(since, move.duration, 25)
        return TorqueUse(self._model, belief, self._settings.sigma,
                         temperature).worst(*move.points(times))

    def _top(self, line):
        moving = np.maximum(np.abs(line), 1e-9)
        acceleration = float(np.min(self._limits.acceleration / moving))
        return PathLimits(self._settings.speed_scale * float(
            np.min(self._limits.velocity / moving)), acceleration, acceleration,
            acceleration / self._settings.rise_time)

    def _fastest(self, line, belief, temperature, caution):
        def solver(load):
            return _Solver(line, TorqueUse(self._model, load, self._settings.sigma, temperature))

        rated = solver(self._rated).solve()
        if belief.source == 'rated':
            return rated and line.move(rated, 'rated')
        certain = solver(LoadBelief(belief.mean, np.zeros((10, 10)), 'estimate'))
        if rated is not None and not certain.keeps(rated):
            # What is held needs more torque than the rated load: the rated limits are no excuse.
            rated = None
        uncertain = solver(belief)
        limits = uncertain.solve()
        if limits is not None and rated is not None:
            careful = _between(rated, limits, caution)
            limits = careful if uncertain.keeps(careful) else limits
        return _faster(line.move(limits, 'estimate'), line.move(rated, 'rated'))

    def _slow(self, line, belief):
        top = line.top
        limits = replace(top, speed=_SPEED_SHARES[-1] * top.speed,
                         acceleration=_SLOW * top.acceleration,
                         deceleration=_SLOW * top.deceleration)
        move = line.move(limits, belief.source)
        return replace(move, feasible=False, reason=(
            f'no acceleration keeps the allowed torque with the {belief.source} load from '
            f'{np.round(line.start, 2).tolist()} to {np.round(line.goal, 2).tolist()} rad; '
            'moving slowly'))


def _faster(*moves):
    moves = [move for move in moves if move is not None]
    return min(moves, key=lambda move: move.duration) if moves else None


def _between(rated, limits, caution):
    """Return limits moved by `caution` towards the rated ones, where they exceed them."""
    def blend(name):
        low, high = getattr(rated, name), getattr(limits, name)
        return high if high <= low else high + caution * (low - high)

    return replace(limits, **{name: blend(name)
                              for name in ('speed', 'acceleration', 'deceleration')})


class _Line:
    """The path of a move, from a state (s, v, a) on."""

    def __init__(self, start, goal, top, state=(0.0, 0.0, 0.0)):
        self.start, self.goal, self.state = start, goal, state
        self.top = top(goal - start)

    def move(self, limits, basis):
        """Return the PlannedMove with these limits; None without limits or when it won't fit."""
        profile = limits and make_profile(limits, self.state)
        return profile and PlannedMove(self.start, self.goal, profile, limits, self.top, basis)


class _Solver:
    """Finds the largest accelerations along a line that keep one TorqueUse below its limit."""

    def __init__(self, line, use):
        self._line, self._use = line, use

    def solve(self):
        """
        Return the PathLimits of the shortest move; None when no acceleration keeps the torques.

        Friction grows with speed: where little torque is left, a slower move may accelerate so
        much more that it takes less time.
        """
        best, shortest = None, np.inf
        for share in _SPEED_SHARES:
            limits = self._at_speed(replace(self._line.top,
                                            speed=share * self._line.top.speed))
            move = self._line.move(limits, '')
            if move is not None and move.duration < shortest:
                best, shortest = limits, move.duration
            elif best is not None:
                break
        return best

    def keeps(self, limits):
        """Tell whether the whole move with these limits keeps the torques."""
        move = self._line.move(limits, '')
        if move is None:
            return False
        times = np.union1d(move.profile.time, np.linspace(0.0, move.duration, 25))
        return self._use.worst(*move.points(times)) <= 1.0

    def _at_speed(self, limits):
        deceleration, acceleration = limits.deceleration, None
        # The second round wins back what a lower peak speed allows.
        for _ in range(2):
            acceleration = _largest(lambda x: self._phase_keeps(replace(
                limits, acceleration=x, deceleration=deceleration), 0), limits.acceleration)
            if acceleration is None:
                return None
            deceleration = _largest(lambda x: self._phase_keeps(replace(
                limits, acceleration=acceleration, deceleration=x), 1), limits.deceleration)
            if deceleration is None:
                return None
            if deceleration == limits.deceleration:
                break
        for shrink in _SHRINK:
            found = replace(limits, acceleration=shrink * acceleration,
                            deceleration=shrink * deceleration)
            if self.keeps(found):
                return found
        return None

    def _phase_keeps(self, limits, phase):
        """Tell whether accelerating (phase 0) or decelerating (phase 1) keeps the torques."""
        move = self._line.move(limits, '')
        if move is None:
            # Too gentle to stop in the path left; a stronger deceleration is asked for next.
            return True
        knots = move.profile.time
        knots = knots[:move.profile.first_cruise + 1] if phase == 0 \
            else knots[move.profile.first_brake:]
        times = np.union1d(knots, np.linspace(knots[0], knots[-1], 6))
        return self._use.worst(*move.points(times)) <= 1.0
