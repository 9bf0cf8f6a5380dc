"""The supervisor with a fake arm and a fake estimator: a cell that runs through cycles."""

from control_helpers import (covariance_of, FakeArm, FakeModel, FAR_PICK, FAR_PLACE, HOME,
                             load_vector)
import numpy as np

from hand_load_estimator.control.supervisor import CycleSettings, Supervisor
from hand_load_estimator.load import products_from_message

MODEL = FakeModel(agility=3.0)
WAYPOINTS = {'home': HOME, 'pick': FAR_PICK, 'place': FAR_PLACE}
TICK = 0.01


class Cell:
    """Supervisor, fake arm and a fake estimator that is right after a moment of motion."""

    def __init__(self, mass=2.0, start=HOME, model=MODEL, waypoints=WAYPOINTS, **settings):
        self.supervisor = Supervisor(model, CycleSettings(waypoints, dwell=0.5, home_dwell=0.2,
                                                          **settings))
        self.supervisor.start()
        self.arm, self.now, self.mass = FakeArm(model, start), 50.0, mass
        self.estimating, self.hearing, self.ready = True, True, True
        self.residuals, self.velocities, self.sent = True, True, []
        self.phases, self.limits = [], {}
        self._load_id, self._moved = 0, 0.0
        self._residuals = [self.arm.residual(self.now)] * 3

    def run(self, seconds, until=lambda cell: False):
        for _ in range(round(seconds / TICK)):
            self._step()
            if until(self):
                return True
        return False

    def _step(self):
        self.now += TICK
        self._grip()
        q, v, _ = self.arm.state(self.now)
        if self.hearing:
            self.supervisor.measured(self.now, q, v if self.velocities else np.full(6, np.nan))
            # Late by the estimator's filter.
            if self.residuals:
                self.supervisor.residual(self.now, self._residuals[-1])
            self._residuals = [self.arm.residual(self.now), *self._residuals[:-1]]
        if self.estimating:
            self._estimate()
        trajectory = self.supervisor.tick(self.now, self.ready)
        if trajectory is not None:
            self.sent.append((trajectory, self.arm.state(self.now)))
        if trajectory is not None and self.ready:
            self.arm.take(trajectory, self.now)
        if not self.phases or self.phases[-1] != self.supervisor.phase:
            self.phases.append(self.supervisor.phase)
        self.limits[self.supervisor.phase] = self.supervisor.limits

    def _grip(self):
        held = self.arm.load[0] > 0.0
        wanted = self.supervisor.phase in ('at_pick', 'carrying') or (
            held and self.supervisor.phase == 'stopped')
        if held != wanted:
            self.arm.load = products_from_message(load_vector(self.mass)) * wanted
            self._load_id, self._moved = self._load_id + 1, 0.0

    def _estimate(self):
        policy, moving = self.supervisor.policy, self.supervisor.moving
        self._moved += TICK * moving
        known = self._moved > 0.15
        std = 0.05 if known else 5.0
        mass = self.arm.load[0] if known else 4.0
        policy.estimate(self.now, load_vector(mass), covariance_of(std, 0.005 if known else 0.1))
        policy.status(self.now, 'DETERMINED' if known else 'WAITING_FOR_MOTION',
                      str(self._load_id))
