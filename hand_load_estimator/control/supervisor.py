"""Runs the pick-and-place cycle: what to send when, from what is measured and believed."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from .acceleration_limits import MovePlanner, PlanSettings
from .braking import braking_trajectory
from .collision_threshold import CollisionDetector, CollisionThresholds, ThresholdSettings
from .cycle_limits import rated_cycle_limits
from .fallback import FallbackSettings, LoadPolicy
from .measured_state import MeasuredState
from .pick_place import pick_and_place
from .running_move import RunningMove
from .tick_clock import LATE, TickClock
from .torque_use import TorqueUse

_AT_GOAL = 0.02          # [rad] a position controller's static error is far below this
_ON_PATH = 0.1           # [rad] nearer: the motion is being followed, and may be changed
_OFF_PATH = 0.25         # [rad] farther from the reference: the motion is not being followed
_SET_OFF = 0.003         # [rad] from where it stood: the joint moves, the command has arrived
_SETTLE = 1.0            # [s] after which an arm that is not at the goal is sent there again
_REPLAN_PERIOD = 0.15    # [s]
_NEXT_STATE = 0.05       # [s] in which a joint state comes at any usual rate
_PAUSE = 0.3             # [s] between a stop and the next try
_TRIES = 3               # tries of a step after which an arm that does not follow is left alone


@dataclass(frozen=True)
class CycleSettings:
    """
    The cycle: waypoints name -> (n,) [rad] for home, pick and place; cycles (0: without end).

    dwell [s] at pick and place, in which the hand grips or releases; home_dwell [s] at home.
    """

    waypoints: dict
    cycles: int = 1
    dwell: float = 1.5
    home_dwell: float = 1.0
    plan: PlanSettings = field(default_factory=PlanSettings)
    fallback: FallbackSettings = field(default_factory=FallbackSettings)
    thresholds: ThresholdSettings = field(default_factory=ThresholdSettings)


class Supervisor:
    """
    The controller without its messages.

    Feed measured(), residual() and policy.estimate(), policy.status(); call tick() at a fixed
    rate and send the Trajectory it returns. Nothing moves before start(), nor after a reset()
    until it comes again. phase: waiting, done, stopped or the Step's; tries: how often the present
    step was begun again because the arm did not follow; move: the PlannedMove under way or last,
    None before the first; in_force: Thresholds now, None before joint states; counts: events since
    the start.
    """

    def __init__(self, model, settings):
        self.robot, self._model, self._settings = model.robot, model, settings
        self.policy = LoadPolicy(model.robot, settings.fallback)
        self.detector = CollisionDetector(settings.thresholds)
        self.temperature = np.full(model.robot.n, np.nan)
        self.phase, self.move, self.in_force, self.tries = 'waiting', None, None, 0
        self.stop_reason, self.counts = '', Counter()
        self._planner = MovePlanner(model, settings.plan)
        self._rated_limits = rated_cycle_limits(self._planner, model.robot, settings.waypoints,
                                                settings.plan.speed_scale)
        self._move_limits = None
        self._thresholds = CollisionThresholds(model, settings.thresholds)
        self._steps = pick_and_place(settings.cycles, settings.dwell, settings.home_dwell)
        self._step, self._run, self._braking, self._goal = next(self._steps), None, None, None
        self._dwell_until, self._pause_until, self._next_replan = None, None, 0.0
        self._measured, self._clock = MeasuredState(), TickClock()
        self._stood, self._standing = None, np.zeros(model.robot.n, dtype=bool)

    @property
    def moving(self):
        """Whether a motion is under way."""
        return self._run is not None or self._braking is not None

    @property
    def limits(self):
        """
        The MotionLimits in force.

        Those of the move while the load it was planned for is believed, else the smallest of
        the cycle with the rated load.
        """
        if self.move is None or (self.move.basis == 'estimate' and not self.policy.trusted):
            return self._rated_limits
        return self._move_limits

    def measured(self, now, q, v):
        """Take position and velocity (n,), NaN where unknown, measured at `now` [s]."""
        self._measured.take(now, q, v)

    def residual(self, stamp, torque):
        """Take the residual torque (n,) [Nm] of `stamp` [s]."""
        self.policy.residual(stamp, self.detector.judges(stamp))
        self.detector.check(stamp, torque)

    def start(self):
        """Go on with the cycle, from where the arm is; return why it cannot, or nothing."""
        if self.phase == 'stopped':
            return f'{self.stop_reason}; reset it first'
        if self.phase == 'waiting':
            self.phase = self._step.phase if self._step else 'done'
        return ''

    def reset(self):
        """Clear a collision or stop; the interrupted step begins again with start()."""
        self.detector.reset()
        self.stop_reason, self._goal, self.tries = '', None, 0
        if self.phase == 'stopped':
            self.phase = 'waiting' if self._step else 'done'

    def stop(self):
        """Return the braking trajectory that ends a motion under way; None at rest."""
        return self._brake(self._clock.now) if self._run is not None else None

    def tick(self, now, ready=True):
        """
        Return the Trajectory to send at `now` [s], its time 0, or None.

        ready: whether somebody takes trajectories; no motion begins before that.
        """
        step = self._clock.tick(now, self._measured.count)
        if step < 0.0:
            self._clock_went_back(now, step)
        if self._clock.late:
            self.counts['late_tick'] += 1
        ahead = self._clock.told(self._measured.count)
        if ahead:
            self._settle_step(now, ahead)
        if self._measured.q is None:
            return None
        self.policy.update(now, self._shows_load(now))
        out = self._act(now, ready)
        self._watch(now)
        return out

    def _shows_load(self, now):
        """
        Tell whether a motion under way shows what the hand took.

        What was sent is none yet: a protective stop may hold the arm. What somebody else does
        while the hand grips tells of before.
        """
        return self._run is not None and self.policy.expecting and self._measured.moves(
            now, self.robot.gravity_loaded(self._measured.q))

    def _settle_step(self, now, step):
        """Tell a clock that went ahead from a stall: where is the arm on what was sent?"""
        if self._run is not None:
            earlier, here = (np.max(np.abs(self._measured.q - self._run.state(t)[0]))
                             for t in (now - step, now))
            if earlier < here:
                self.counts['clock_jump'] += 1
                self._run.shift(step)

    def _clock_went_back(self, now, step):
        """Go on as if no time had passed: what was sent is under way whatever the clock says."""
        self.counts['clock_jump'] += 1
        self._measured.clock_went(now, step)
        if self._run is not None:
            self._run.shift(step)
        if self._braking is not None:
            self._braking = self._braking.shifted(step)
        self._dwell_until, self._pause_until = (
            None if until is None else until + step
            for until in (self._dwell_until, self._pause_until))
        self._next_replan += step

    def _act(self, now, ready):
        if self._braking is not None and now > self._braking.end:
            self._braking = None
        if self.phase == 'stopped':
            return None
        if self.detector.collided:
            if (self._run is not None and self._clock.open(_NEXT_STATE)
                    and not self._measured.fresh(now)):
                # Where the arm is to brake from is known a moment later.
                return None
            return self._halt(now, self._describe_collision())
        if self._run is not None:
            return self._follow(now)
        if self._step is None or self.phase == 'waiting':
            return None
        self.phase = self._step.phase
        if not self._step.target:
            return self._dwell(now)
        return self._move(now) if ready and self._may_move(now) else None

    def _may_move(self, now):
        pausing = self._pause_until is not None and now < self._pause_until
        return not pausing and self._measured.rests(now)

    def _dwell(self, now):
        if self._dwell_until is None:
            self._dwell_until = now + self._step.dwell
            if self._step.grips:
                self.policy.expect_change()
        if now >= self._dwell_until:
            self._dwell_until = None
            self._advance()
        return None

    def _advance(self):
        self._step, self.tries = next(self._steps, None), 0
        self.phase = self._step.phase if self._step else 'done'

    def _move(self, now):
        target = np.asarray(self._settings.waypoints[self._step.target], dtype=float)
        # Where the arm was sent, not where it hangs a milliradian below: no step in the command.
        q = self._measured.q
        near = self._goal is not None and np.max(np.abs(q - self._goal)) < _AT_GOAL
        start = self._goal if near else q
        if np.max(np.abs(start - target)) < 1e-3:
            self._goal = target
            self._advance()
            return None
        move = self._planner.plan(start, target, self.policy.belief, self.temperature,
                                  self.policy.caution)
        self._run, self._next_replan = RunningMove(move, now), now + _REPLAN_PERIOD
        self._stood, self._standing = q, np.ones(self.robot.n, dtype=bool)
        self._accept(move)
        self.counts['motions'] += 1
        return self._run.trajectory.shifted(-now)

    def _accept(self, move):
        self.move = move
        self._move_limits = move.motion_limits(self.robot.limits, self._settings.plan.speed_scale)

    def _follow(self, now):
        if self._clock.open(LATE):
            # Whether the clock or the controller was at fault, the next joint state tells.
            return None
        if self._measured.stopped(now) and not self._clock.late:
            return self._halt(now, 'the joint states have stopped while the arm was moving')
        # The reference moves on; compared with where the arm was, it would seem far away.
        fresh = self._measured.fresh(now)
        distance = self._distance(now)
        if fresh and distance > _OFF_PATH:
            self.counts['off_path'] += 1
            return self._retry(now, f'is {distance:.2f} rad from where it was sent')
        if now >= self._run.end:
            return self._arrive(now)
        if now >= self._next_replan and fresh and distance < _ON_PATH:
            self._next_replan = now + _REPLAN_PERIOD
            if self._run.replan(now, self._planner, self.policy.belief, self.temperature,
                                self.policy.caution):
                self.counts['replans'] += 1
                self._accept(self._run.move)
                return self._run.trajectory.shifted(-now)
        return None

    def _distance(self, now):
        return np.max(np.abs(self._measured.q - self._run.state(now)[0]))

    def _arrive(self, now):
        if np.max(np.abs(self._measured.q - self._run.goal)) < _AT_GOAL:
            self._goal, self._run = self._run.goal, None
            self._advance()
        elif now > self._run.end + _SETTLE:
            self.counts['not_arrived'] += 1
            return self._retry(now, 'does not arrive')
        return None

    def _retry(self, now, what):
        """Stop, and begin the step again from where the arm is, but not for ever."""
        self.tries += 1
        if self.tries >= _TRIES:
            # Held by a protective stop it would set off on its own the moment it is released.
            return self._halt(now, f'the arm {what}, {self.tries} times in a row')
        brake = self._brake(now)
        self._run, self._braking, self._goal = None, brake.shifted(now), None
        self._pause_until = now + brake.duration + _PAUSE
        return brake

    def _halt(self, now, reason):
        """Stop and wait for a reset."""
        self.phase, self.stop_reason = 'stopped', reason
        self.counts['stops'] += 1
        self._dwell_until = None
        if self._run is None:
            return None
        brake = self._brake(now)
        self._run, self._braking, self._goal = None, brake.shifted(now), None
        return brake

    def _brake(self, now):
        use = TorqueUse(self._model, self.policy.belief, self._settings.plan.sigma,
                        self.temperature)
        return braking_trajectory(*self._brake_from(now), use, self.robot.limits.acceleration)

    def _brake_from(self, now):
        """Return position and velocity to brake from: measured, or else as commanded."""
        q, v = self._measured.q, self._measured.v
        measured = self._measured.fresh(now)
        if measured and not np.isfinite(v).all():
            # Without velocities the reference has them, as long as the arm follows it.
            measured = self._distance(now) > _ON_PATH
        if measured:
            return self._measured.at(now), np.nan_to_num(v)
        return self._run.state(now)[:2]

    def _reference(self, now):
        if self._run is not None:
            return self._run.state(now)
        if self._braking is not None:
            return self._braking.sample(now)
        still = np.zeros(self.robot.n)
        return self._measured.q, still, still

    def _watch(self, now):
        if self._run is None:
            self._standing[:] = False
        elif self._standing.any():
            self._standing &= np.abs(self._measured.q - self._stood) < _SET_OFF
        thresholds, fixed = self._thresholds.at(*self._reference(now), self.policy.belief,
                                                self.temperature, self._standing)
        self.in_force = self.detector.record(now, thresholds, fixed)

    def _describe_collision(self):
        joints, beyond, threshold = self.detector.what
        return 'collision: ' + ', '.join(
            f'{self.robot.joints[j]} {beyond[j]:.1f} Nm beyond the expected torque, '
            f'threshold {threshold[j]:.1f} Nm' for j in joints)
