"""The simulated arm: everything a real one has between a trajectory and its joint states."""

from copy import deepcopy

import numpy as np

from ..load import LoadParameters, together
from .arm import Arm
from .difficulty import DEFAULT
from .drive import Drive
from .friction import Friction
from .hidden import apply_effects
from .history import History
from .sensors import Sensors
from .setpoint import Setpoint
from .thermal import Thermal
from .truth import draw_truth

# Bristles of 20 kNm/rad on rotors of 3.5 kg m^2 swing at 80 rad/s, drives close at 100 rad/s:
# a millisecond is a tenth of a radian of either.
LONGEST_STEP = 1e-3  # [s]
_WARMING_STEP = 0.01  # [s] temperatures change over minutes


class Situation:
    """What hidden effects may depend on: time and (n,) arrays of the present moment."""

    def __init__(self, n):
        self.time = 0.0
        self.position, self.velocity, self.gear_torque, self.temperature = np.zeros((4, n))


class Plant:
    """
    An arm that differs from its robot file as `seed` draws it.

    start_temperature, ambient_temperature [degC] (None: the start temperature); effects: what
    read_effects returns; load: LoadParameters or None; rate [Hz] of `step` and of the sensors;
    start_position (n,) [rad] (None: zero, or the middle of the range where zero is outside); run:
    number that draws noise and state of rest anew, as another run of the same arm has them.
    The same arguments and calls give the same data. Raises ConfigurationError for effects that
    cannot be had.
    """

    def __init__(self, robot, seed=0, start_temperature=25.0, ambient_temperature=None,
                 effects=(), load=None, rate=500.0, start_position=None, difficulty=DEFAULT,
                 run=0):
        draws, start, noise = (np.random.default_rng([seed, k, run * (k > 0)])
                               for k in range(3))
        if ambient_temperature is None:
            ambient_temperature = start_temperature
        self.robot, self.rate = robot, float(rate)
        self.truth = draw_truth(robot, difficulty, draws)
        apply_effects(effects, robot, self.truth, seed)
        self._period = 1.0 / self.rate
        self._dt = self._period / np.ceil(self._period / LONGEST_STEP - 1e-9)
        self._steps = 0
        self._arm = Arm(robot, self.truth.links, self.truth.rotor, self.truth.gravity)
        self._thermal = Thermal(robot, difficulty, start_temperature, ambient_temperature, start)
        self._sensors = Sensors(robot, self.truth, difficulty, noise)
        self._arm.position[:] = _start(robot) if start_position is None else start_position
        self.attach(load)
        self._setpoint = Setpoint(robot.joints, self._arm.position, robot.stops)
        self._settle(robot, difficulty, start)

    def _settle(self, robot, difficulty, rng):
        """Begin at rest in balance, with friction left over from a motion nobody saw."""
        n = robot.n
        held = self._arm.hold_torque()
        self._friction = Friction(self.truth.friction, self._thermal.gear, held, rng)
        self._situation = Situation(n)
        self._hidden, self._passive, self._link_torque, self._work = np.zeros((4, n))
        self._heat, self._square = np.zeros((2, n))
        self._warmed = 0.0
        self._observe()
        self._situation.gear_torque[:] = held
        self._act()
        self._drive = Drive(robot, difficulty)
        self._drive.balance(self._setpoint.state,
                            held + self._friction.torque + self._hidden)
        self._move()
        self._history = History(self.truth.effort_delay, self._dt, self._reported_torque())

    @property
    def time(self):
        """Simulated time [s] since the start."""
        return self._steps * self._dt

    @property
    def true_load(self):
        """What was attached to the hand, as LoadParameters; what hidden effects hold is not."""
        return self._load

    @property
    def noise(self):
        """Standard deviation (n,) [Nm] of the effort's white noise."""
        return self._sensors.noise

    @property
    def moving(self):
        """Tell whether a trajectory is under way."""
        return self._setpoint.moving

    def state(self):
        """Return true position, velocity, acceleration, drive (or link) torque, (n,) each."""
        return (self._arm.position.copy(), self._arm.velocity.copy(),
                self._arm.acceleration.copy(), self._reported_torque().copy())

    def reported_effort(self):
        """Return what the robot believes (n,) [Nm] before noise, steps and torque constants."""
        return self._sensors.reported(self._history.delayed(), self._thermal.sensor,
                                      self._arm.position)

    def friction_torque(self):
        """Return the true friction torque (n,) [Nm]."""
        return self._friction.torque.copy()

    def true_temperatures(self):
        """Return the gears' and the sensors' true temperatures, (n,) each [degC]."""
        return self._thermal.gear.copy(), self._thermal.sensor.copy()

    def attach(self, load):
        """Hang LoadParameters on the hand in place of what is there; None empties the hand."""
        self._load = LoadParameters() if load is None else load
        self._hang(self._held_now())

    def set_trajectory(self, names, times, positions, velocities=None, accelerations=None):
        """
        Replace the trajectory under way; times [s] count from now.

        names: the arm's joints in any order; positions, velocities, accelerations (k, n).
        Raises TrajectoryError (a ValueError) for what ros2_control's controller refuses, and for
        positions that the URDF's limits exclude.
        """
        self._setpoint.take(self.time, names, times, positions, velocities, accelerations)

    def refuse_trajectory(self, *trajectory):
        """Raise what set_trajectory would, and move nothing."""
        deepcopy(self._setpoint).take(self.time, *trajectory)

    def step(self):
        """Advance one sensor period."""
        self.step_until(self.time + self._period)

    def step_until(self, time):
        """Advance in steps of at most a millisecond until the simulated time [s] is there."""
        wanted = int(round(time / self._dt))
        while self._steps < wanted:
            self._step()

    def measure(self):
        """Return position [rad], velocity [rad/s], effort (robot file's kind), (n,) each."""
        return self._sensors.measure(self._arm.position, self._arm.velocity,
                                     self._history.delayed(), self._thermal.sensor)

    def measure_temperatures(self):
        """Return the reported joint temperatures (n,) [degC]."""
        return self._sensors.temperatures(self._thermal.sensor)

    def _step(self):
        dt = self._dt
        self._arm.integrate(dt)
        self._steps += 1
        if self.truth.held and (now := self._held_now()) != self._held:
            self._hang(now)
        velocity = self._arm.velocity
        self._friction.step(velocity, self._situation.gear_torque, dt)
        self._observe()
        self._act()
        self._drive.step(self._setpoint.advance(self.time), self._arm.position, velocity, dt)
        self._move()
        self._history.add(self._reported_torque())
        self._warm(velocity, dt)

    def _held_now(self):
        """Return the indices of what hidden effects hold now."""
        return [k for k, held in enumerate(self.truth.held)
                if held.start <= self.time < held.end]

    def _hang(self, now):
        """Put on the hand the load and, beside it, what is held by index."""
        self._held = now
        self._arm.attach(together([self._load, *(self.truth.held[k].load for k in now)]))

    def _observe(self):
        now, arm = self._situation, self._arm
        now.time = self._steps * self._dt
        now.position, now.velocity = arm.position, arm.velocity
        now.temperature = self._thermal.gear

    def _act(self):
        """Sum the torque (n,) hidden effects ask of the drives into self._hidden."""
        truth, hidden = self.truth, self._hidden
        if not truth.joint_torques and not truth.forces:
            return
        hidden[:] = 0.0
        for effect in truth.joint_torques:
            hidden += effect.torque(self._situation, self._dt)
        if truth.forces:
            place, rotation, jacobian = self._arm.hand()
            for effect in truth.forces:
                hidden -= effect.force(self._situation.time, place, rotation,
                                       self._dt) @ jacobian

    def _move(self):
        """Find the acceleration now, and the torque that goes through the gears."""
        work, through = self._work, self._link_torque
        np.subtract(self._drive.torque, self._friction.torque, out=through)
        np.subtract(through, self._hidden, out=work)
        acceleration = self._arm.accelerate(work)
        np.multiply(self.truth.rotor, acceleration, out=work)
        through -= work
        self._situation.gear_torque[:] = through

    def _reported_torque(self):
        kind = self.robot.file.effort.kind
        return self._link_torque if kind == 'link_torque' else self._drive.torque

    def _warm(self, velocity, dt):
        work = self._work
        np.multiply(self._friction.torque, velocity, out=work)
        self._heat += work
        np.multiply(self._drive.torque, self._drive.torque, out=work)
        self._square += work
        self._warmed += dt
        if self._warmed >= _WARMING_STEP:
            steps = self._warmed / dt
            self._thermal.step(np.maximum(self._heat, 0.0) / steps, self._square / steps,
                               self._warmed)
            self._friction.set_temperature(self._thermal.gear)
            self._heat[:] = self._square[:] = 0.0
            self._warmed = 0.0


def _start(robot):
    """Return zero, or the middle of the range of joints that cannot be at zero."""
    limits = robot.limits
    middle = 0.5 * (limits.lower + limits.upper)
    return np.where((limits.lower <= 0.0) & (limits.upper >= 0.0), 0.0, middle)
