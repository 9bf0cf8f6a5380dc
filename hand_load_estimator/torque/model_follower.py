"""Evaluate a torque model along a stream of samples, as the estimator needs it."""

from dataclasses import dataclass

import numpy as np

from ..effects import EffectInput, LATE
from ..load import products_from_message
from ..torque_model import drift_std, DRIFTS, nuisance_columns, uncertain_directions
from .columns import first_of_joints, real_torque, torque_columns, warmth_of
from .late_rows import LateRows
from .load_through_effects import gear_with, load_through_effects
from .misread_weight import misread_columns, misread_directions
from .noise import SampleNoise
from .play import PlayState
from .presliding import doubt_after, REST_TIME, STUCK_TIME, stuck_variance
from .shown_friction import course_of
from .shown_stream import ShownStream
from .sliding import surely_slides
from .start_doubt import StartDoubt


@dataclass(frozen=True)
class Prediction:
    """
    The torque model at one MotionSample.

    difference (n,) [Nm] = tau_real - tau_mdl; load_columns K (n, 10); model_columns (n, r): what
    unit-variance uncertainties do to the torque: those of misread_weight.py, then the model's own
    as it states them; z, doubt (n,): friction state and how far its start is unknown; stuck (n,)
    [Nm^2]: variance of that; friction (n,) [Nm]: the level that a joint which stands can hold, as
    its gear is loaded now. An estimate of the load suffers less from them (load_agreement.py):
    density (n,) [Nm^2 s] of the difference beside the load and column_scale (r,) of model_columns
    are what it counts.
    noise (n,) [Nm^2]: variance of a sample beyond the model's own residual, where the driver
    reports less often, or more noise, than in the recordings the model was made from. standing
    (n,): by how much less a sample counts while an arm without friction stands.
    """

    difference: np.ndarray
    load_columns: np.ndarray
    model_columns: np.ndarray
    z: np.ndarray
    doubt: np.ndarray
    stuck: np.ndarray
    friction: np.ndarray
    density: np.ndarray
    column_scale: np.ndarray
    noise: np.ndarray | float = 0.0
    standing: np.ndarray | float = 1.0

    @property
    def counted(self):
        """
        Density (n,) [Nm^2 s] by which a sample counts in sums over time.

        Whether it is another load's or a push is judged by `density`: that may come at any time.
        """
        return self.density * self.standing


class ModelFollower:
    """
    Evaluate a TorqueModel along a stream of MotionSamples, keeping the friction's path.

    measured: the samples come from an arm, so that noise can be told from them. column_scale
    (r,): as of every Prediction.
    """

    def __init__(self, model, directions=12, seed=0, measured=True):
        self.model = model
        distance = model.presliding_distance()
        self._shown = ShownStream((distance, model.presliding_plastic()), model.contact_level())
        self._start = StartDoubt(distance)
        self._friction = model.held_friction()
        # Whatever varies there is noise, at rest too; but what does not vary is no less wrong.
        self._frictionless = self._friction == 0.0
        self._gear_friction = np.abs(first_of_joints(
            model.robot.n, model.uses, 'load_dependent_friction', model.mean))
        self._uncertain = uncertain_directions(model, directions, seed)
        self._ahead = misread_directions(model.robot.n)
        # An estimate suffers less from what the model states; misread_weight.py's count in full.
        self.column_scale = np.full(self.uncertainties, np.sqrt(model.residuals.load_share))
        self.column_scale[:self._ahead] = 1.0
        residuals = model.residuals
        self._noise = SampleNoise(residuals.rmse, residuals.load_intensity) if measured else None
        self._known = self._drift = None
        self._carried = np.zeros(10)
        self._stood = 0.0
        delays = {use.joint: (model.mean[where.start], use.shape['shift'])
                  for use, where in model.slices() if use.name == LATE}
        self._longest = max((seconds for _, seconds in delays.values()), default=0.0)
        self._late = LateRows(delays)
        self._late_doubt = LateRows({j: (1.0, seconds) for j, (_, seconds) in delays.items()})
        self._forget_torques()

    @property
    def uncertainties(self):
        """Number r of model columns."""
        return self._ahead + self._uncertain.shape[1] + DRIFTS * self.model.robot.n

    def restart(self):
        """Forget the path, as after a gap in the data."""
        self._shown.restart()
        self._start.restart()
        if self._noise is not None:
            self._noise.restart()
        self._forget_torques()

    def _forget_torques(self):
        self._before = None
        self._late.restart()
        self._late_doubt.restart()
        self._teeth = [PlayState() for _ in self.model.robot.joints]

    def carry(self, belief, method, beside=0.0):
        """
        Take a Method's Belief of the load: its torque too loads gears, effects grow with it, and
        so does what misreads weights.

        beside: products (10,) of what is held and not in the belief.
        """
        self._carried = products_from_message(belief.mean) + method.tared + beside

    def another_load(self):
        """Take the load for another one, of which a rest has told nothing yet."""
        self._stood = 0.0

    def _gear(self, x):
        """
        Return the torque (n,) [Nm] of what is believed to be held, and gear, gear_way (n,) of
        EffectInput with it; no torques where the model has no effect that depends on them.
        """
        if not self.model.layout.needs:
            return 0.0, (0.0, 0.0)
        return gear_with(self.model, x, self._carried)

    def _plain_gear(self, x, columns, load):
        """Return the gears' torque (n,) [Nm], of columns (n, P) and load columns (n, 10)."""
        layout, mean = self.model.layout, self.model.mean
        gear = columns[:, :layout.links] @ mean[:layout.links] + load @ self._carried
        return gear + layout.pull(x, mean)[0] if layout.pulls else gear

    def _columns(self, x, dt, believed):
        model = self.model
        if not model.layout.needs:
            return torque_columns(model.robot, model.layout, x)
        columns = torque_columns(model.robot, model.layout, x, model.mean, np.array([dt]),
                                 before=self._before, teeth=(self._teeth, believed))
        if self._longest:
            self._remember(model.layout.prompt_torque(columns, model.mean), dt)
        return columns

    def _remember(self, torque, dt):
        """Keep the last torques, as far back as a delay may reach."""
        past, gaps = self._before or (torque[:0], np.zeros(0))
        past, gaps = np.concatenate([past, torque]), np.append(gaps, dt)
        ages = np.cumsum(gaps[::-1])[::-1] - gaps
        keep = np.append(ages[1:] < self._longest, True)
        self._before = past[keep], gaps[keep]

    def _as_late(self, load, turned, nuisances, columns, dt):
        """Return K (n, 10), torque (n,) and nuisances (n, r) as they come with what is late."""
        # What a delay's own share may be off by is late already.
        own, late = np.zeros_like(nuisances), self.model.layout.late
        known = slice(self._ahead, self._ahead + self._uncertain.shape[1])
        own[:, known] = columns[:, late] @ self._uncertain[late]
        rows = np.concatenate([load, turned[:, None], nuisances - own], axis=1)
        rows = rows + self._late.change(rows, dt)
        return rows[:, :10], rows[:, 10], rows[:, 11:] + own

    def _misread_torque(self, x, columns, gear, added):
        """
        Return misread_columns at x, of columns Y (n, P).

        gear (n,) [Nm]: torque of the gears; added (n,) [Nm]: the load's, through declared effects.
        """
        # A delay delays these with everything else.
        torque = self.model.layout.prompt_torque(columns, self.model.mean) + added
        return misread_columns(self.model, x.q[0], x.z[0], gear, torque, self._carried)

    def _standing(self, doubt, dt):
        """
        Return Prediction's `standing` after dt [s]; doubt (n,): about the friction state.

        A model's error at one pose is the same for a minute as for a second. Of joints with
        friction that is said by what they hold.
        """
        if not self._frictionless.any():
            return 1.0
        self._stood = self._stood + dt if doubt.min() >= 1.0 else 0.0
        factor = doubt_after(max(self._stood, REST_TIME)) ** 2
        return np.where(self._frictionless, factor, 1.0)

    def update(self, sample):
        """Return the Prediction at a MotionSample."""
        robot = self.model.robot
        warmth = warmth_of(robot, sample.temperature)
        shown = self._shown.at(course_of(sample), sample.dt, warmth, sample.messages)
        z, at_once = self._shown.z, self._shown.at_once
        doubt = self._start.update(self._shown.moved, sample.q, sample.v, sample.dt)
        x = EffectInput(
            *(s[None] for s in (sample.q, sample.v, sample.a, warmth, z)), at_once=at_once[None],
            shown=shown,
            jerk=None if sample.jerk is None else sample.jerk[None])
        believed, gear = self._gear(x)
        columns = self._columns(x, sample.dt, believed)
        difference = real_torque(robot, sample.q, sample.effort) - columns[0] @ self.model.mean
        known = np.isfinite(sample.temperature)
        if self._known is None or (known != self._known).any():
            self._known, self._drift = known, drift_std(self.model, known)
        told, load, turned = columns[0], robot.load_columns(columns[0, :, :10 * robot.n]), 0.0
        if self.model.layout.needs:
            told, load, turned = load_through_effects(self.model, columns[0], x, self._carried,
                                                      believed, gear)
        else:
            gear = self._plain_gear(x, columns[0], load), 0.0
        nuisances = np.concatenate([
            self._misread_torque(x, columns[0], gear[0], load @ self._carried + turned),
            nuisance_columns(told[None], self._uncertain, self._drift, x.z, x.v)[0]], axis=1)
        # What friction may be off by at a reversal grows with it.
        level = self._friction + self._gear_friction * np.abs(gear[0])
        stuck = stuck_variance(z, doubt, sample.v, level)
        stuck = stuck + self._late_doubt.change(stuck[:, None], sample.dt)[:, 0]
        # Identification measured the residual's density; sampled more rarely it has more.
        stated = density = self.model.residuals.load_intensity
        if self._noise is not None:
            density = self._noise.update(
                difference, sample.dt, sample.messages,
                self._frictionless | surely_slides(sample.v, z, doubt))
        noise = (density - stated) / sample.dt
        density = density + self.model.residuals.load_share * 2.0 * STUCK_TIME * stuck
        if self._longest:
            load, turned, nuisances = self._as_late(load, turned, nuisances, columns[0],
                                                    sample.dt)
        return Prediction(difference - turned, load, nuisances, z, doubt, stuck, level, density,
                          self.column_scale, noise, self._standing(doubt, sample.dt))
