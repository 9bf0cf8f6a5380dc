"""From messages to LoadEstimates: the whole estimator without ROS, as node and command use it."""

import numpy as np

from ..errors import HandLoadError
from ..load import LoadEstimate
from ..stream.frozen import told_of_frozen
from ..stream.joint_stream import JointStream
from ..stream.rejected_input import in_words, joint_states_of
from .calibrated import intervals_of
from .impossible_mass import impossible_mass
from .method import checked, LIGHT
from .physical_consistency import published
from .residual_watch import ResidualWatch
from .suggest_motion import MotionSuggester, SuggestionError

# Motion start: a joint that gravity can load exceeds this speed [rad/s] (DESIGN section 6).
MOTION_START = 0.05
# Below this [rad/s] the arm stands.
STANDING = 0.02
# How long LOAD_CHANGED is said after a change [s].
CHANGE_SHOWN = 1.0
# Motion [s] after which a load that was restored from a file is the one still held: another one
# is seen within 0.2 s nearly always.
CONFIRMED_AFTER = 0.5
# Silence [s] in which a hand may have got another load; a driver that falters is quicker.
UNSEEN = 3.0


class TareError(HandLoadError):
    """What is held is not known well enough to be declared zero."""


class Pipeline:
    """
    Estimate one robot's load from its joint states and temperatures.

    model: TorqueModel; method: a Method; determined_std: standard deviations of mass [kg],
    centre of mass [m] and inertia [kg m^2] below which a parameter counts as determined;
    stale_after [s]: silence after which the estimate is stale; model_file: Path the model was
    read from, or None; digest: SHA-256 of that file's content; tool: the Tool that the follower
    takes off, or None. watch: the ResidualWatch of the model; residual (n,) [Nm]: of the bare arm,
    whatever it holds.
    """

    def __init__(self, model, follower, method, determined_std, stale_after=0.5,
                 model_file=None, digest='', tool=None):
        self.model, self.method = model, method
        self.model_file, self.digest, self.tool = model_file, digest, tool
        self.watch = ResidualWatch(model.robot.joints, model.residuals.intensity)
        self._follower = follower
        self._thresholds = np.repeat(determined_std, (1, 3, 6))
        self._stale_after = stale_after
        self._stream = JointStream(model.robot)
        self._began, self._unwatched = False, None
        self._changes_before, self._restored, self._moved = 0, '', 0.0
        self._changes_then = 0
        self._sample = self._suggester = self._fed = None
        self._estimate, self.estimates = None, 0
        self.residual = np.full(model.robot.n, np.nan)
        self._unheard, self._changes_taken = method.state(), method.changes

    @property
    def rejected(self):
        """Counts of rejected input by reason."""
        return dict(self._stream.rejected)

    @property
    def passed_over(self):
        """Number of joint states that name no joint of the robot, or another arm's."""
        return self._stream.passed_over

    @property
    def why_none(self):
        """In words why no joint state was usable, as long as none was."""
        return self._stream.why_none

    @property
    def samples(self):
        """Number of joint states used."""
        return self._stream.accepted

    @property
    def names(self):
        """The ArmNames that tell which joint states are this arm's."""
        return self._stream.names

    @property
    def velocity_stuck(self):
        """Which joints' (n,) velocities are zero while they move: all are done without then."""
        return self._stream.velocity_stuck

    @property
    def frozen(self):
        """For how long [s] joint states have been the same to the last bit."""
        return self._stream.frozen

    @property
    def temperature_names(self):
        """The names (list) that temperatures are taken from, and others alike that are not."""
        return self._stream.temperature_names

    @property
    def intervals(self):
        """In words where the method's standard deviations come from."""
        return intervals_of(self.method)

    @property
    def load_id(self):
        """Number of load changes seen."""
        return self._changes_before + self.method.changes

    @property
    def unconfirmed(self):
        """Whether the load is of before a restart or silence, and may be another by now."""
        return bool(self._restored)

    @property
    def tared_mass(self):
        """Mass [kg] that tare declared zero."""
        return float(self.method.tared[0])

    @property
    def tool_mass(self):
        """Mass [kg] of the known tool."""
        return self.tool.mass if self.tool else 0.0

    @property
    def known_load(self):
        """Products (10,) of what is held beside the estimate: the tool, and what was tared."""
        return self.method.tared + (self.tool.products if self.tool else 0.0)

    @property
    def last_stamp(self):
        """Stamp [s] of the newest joint state, also one that jumps; None before any."""
        return self._stream.last_stamp

    @property
    def reliability(self):
        """What the method says of its answer beside mean and covariance: {name: value}."""
        return getattr(self.method, 'reliability', {})

    @property
    def temperature(self):
        """Last known joint temperatures (n,) [degC]."""
        return self._stream.temperature

    def temperature_reading(self, joint, celsius):
        """Take one joint temperature [degC]."""
        self._stream.temperature_reading(joint, celsius)

    def joint_state(self, stamp, names, position, velocity, effort):
        """
        Take one message; return the new LoadEstimate when there is one, else None.

        What the estimate need not wait for is left to settle(), or else to the next message.
        """
        arms = self._stream.arms
        sample = self._stream.joint_state(stamp, names, position, velocity, effort)
        if 0 < arms < self._stream.arms:
            self._begin_anew()
        if self._fed is None or self.last_stamp < self._fed:
            # Where it begins, or begins anew with another clock: nobody knows how much later.
            self._fed = self.last_stamp
            if self._began:
                self._doubt('as it was before the clock was set back')
        if sample is None:
            return None
        self._watch_residual()
        if sample.fresh:
            self._follower.restart()
            return None
        if self._began and sample.stamp - self._fed > UNSEEN:
            self._doubt(f'as it was {sample.stamp - self._fed:.0f} s ago')
        self._sample, self._fed = sample, sample.stamp
        self.estimates += 1
        prediction = self._follower.update(sample)
        self.residual = prediction.difference
        if self.tool:
            self.residual = self.residual + prediction.load_columns @ self.tool.products
        moves = self._moves(sample)
        self._began = self._began or moves
        belief = self._beside_tool(self.method.update(sample, prediction))
        if self.method.changes != self._changes_taken:
            self._changes_taken = self.method.changes
            self._follower.another_load()
        self._confirm(sample.dt if moves else 0.0)
        self._follower.carry(belief, self.method)
        self._unwatched = sample, prediction
        self._estimate = self._labelled(sample.stamp, belief)
        return self._estimate

    def _beside_tool(self, belief):
        if not self.tool:
            return belief
        return self.tool.beside(belief, self.method.counts_doubts,
                                LIGHT * self.model.robot.rated_load.mass)

    def _begin_anew(self):
        """Forget what is of another arm: its load, what was tared on it, how its model does."""
        told, self._unwatched = self.load_id, None
        self.method.restore(self._unheard)
        self.watch = ResidualWatch(self.model.robot.joints, self.model.residuals.intensity)
        self._changes_before = told + 1 - self.method.changes
        self.reset()

    def _doubt(self, told):
        """Let nothing count as determined until motion tells; told: in words which load it is."""
        self._restored, self._moved, self._changes_then = told, 0.0, self.method.changes

    def _confirm(self, moved):
        """Tell by `moved` [s] of motion more whether what was in doubt is still held."""
        self._moved += moved
        if self._moved >= CONFIRMED_AFTER or self.method.changes > self._changes_then:
            self._restored = ''

    def settle(self):
        """Do what the last estimate did not wait for."""
        self.method.settle()
        self._watch_residual()

    def _watch_residual(self):
        if self._unwatched is not None:
            self.watch.update(*self._unwatched, self.method)
            self._unwatched = None

    def take_over(self, other):
        """
        Go on where the Pipeline of another model of the same joints stops.

        Input, its counts and the number of load changes go on; the load is to be found anew. What
        tare declared zero counts again: the other model measured it, with the other's errors.
        """
        self._stream, self._fed = other._stream, other._fed
        self._stream.use(self.model.robot)
        self._changes_before = other.load_id

    def state(self):
        """Return {name: array}: what restore() in another process goes on from."""
        return {**self.method.state(), **self._watched(), 'load_id': np.array(self.load_id),
                'began': np.array(self._began or bool(self._restored))}

    def _watched(self):
        """Return what the residual watch has seen, as part of a state."""
        return {f'watch_{name}': value for name, value in self.watch.state().items()}

    def restore(self, state, told):
        """
        Go on from a state() of the same robot, model and method; ValueError when it is unusable.

        told: in words where it comes from, said until motion confirms or refutes it. Until then
        nothing counts as determined: nobody knows what the hand did meanwhile.
        """
        counts = checked(state, {'load_id': (), 'began': ()})
        watched = checked(state, {name: value.shape for name, value in self._watched().items()})
        self.method.restore(state)
        self.watch.restore({name.removeprefix('watch_'): value
                            for name, value in watched.items()})
        self._changes_before = int(counts['load_id'])
        self._doubt(told if counts['began'] else '')

    def estimate(self, now):
        """Return the LoadEstimate as of time `now` [s]: the last one, or STALE_INPUT."""
        last, belief = self._stream.last_stamp, self._beside_tool(self.method.belief())
        if last is None:
            return self._say(now, belief, 'NO_DATA', self.why_none, self._determined(belief))
        if now - self._fed > self._stale_after:
            determined = self._determined(belief) & (now - self._fed <= UNSEEN)
            return self._say(last, belief, 'STALE_INPUT', self._why_stale(now), determined)
        return self._estimate or self._labelled(last, belief)

    def _why_stale(self, now):
        """Return in words for how long nothing told of the load, and why, if something arrives."""
        if now - self.last_stamp > self._stale_after:
            return f'no usable joint state for {now - self.last_stamp:.2f} s'
        why = in_words(joint_states_of(self.rejected)) or 'they stop too often'
        return f'no usable joint state for {now - self._fed:.2f} s, though they arrive: {why}'

    def suggest_motion(self, now):
        """
        Return the Suggestion for what is not determined at `now` [s]; takes half a second or two.

        Raises SuggestionError where the arm does not stand, or nobody knows where.
        """
        if self._sample is None:
            raise SuggestionError('where the arm stands is not known: no usable joint states yet')
        if now - self._fed > self._stale_after:
            raise SuggestionError(f'where the arm stands is not known: {self._why_stale(now)}')
        if (np.abs(self._sample.v) > STANDING).any():
            raise SuggestionError('the arm moves; ask again when it stands')
        if self._suggester is None:
            self._suggester = MotionSuggester(self.model, self._thresholds, self.tool)
        # From where the driver says that it stands, without the turns that it takes out.
        return self._suggester.suggest(self.method, self._sample.q - self._stream.turns,
                                       self._sample.temperature)

    def reset(self):
        """Forget the load."""
        self.method.forget()
        self.watch.forget_load()
        self._began, self._estimate, self._restored = False, None, ''

    def tare(self, now):
        """
        Make what is held at `now` [s] the new zero.

        Raises TareError where its mass is not known: what was only assumed is no zero.
        """
        estimate = self.estimate(now)
        for told in told_of_frozen(self.frozen):
            raise TareError(f'{told}; move the arm and tare again')
        if estimate.status not in ('ESTIMATING', 'DETERMINED') or not estimate.determined[0]:
            raise TareError(f'the mass of what is held is not determined: {estimate.status}, '
                            f'{estimate.reason}; move the arm and tare again')
        self.method.tare()
        self._estimate = None

    def _moves(self, sample):
        loaded = self.model.robot.gravity_loaded(sample.q)
        return bool((np.abs(sample.v[loaded]) > MOTION_START).any())

    def _labelled(self, stamp, belief):
        determined = self._determined(belief)
        return self._say(stamp, belief, *self._status(stamp, belief, determined), determined)

    def _status(self, stamp, belief, determined):
        """Return status and reason while measurements arrive; determined (10,) bool."""
        change = self.method.last_change
        impossible = impossible_mass(belief, self.tared_mass)
        if self._restored or not self._began:
            return 'WAITING_FOR_MOTION', _joined(self._why_waiting(), impossible)
        if mismatch := _joined(self.method.mismatch, impossible):
            return 'MODEL_MISMATCH', mismatch
        if change is not None and 0.0 <= stamp - change < CHANGE_SHOWN:
            return 'LOAD_CHANGED', 'recent torques belong to another load'
        if determined[:4].all():
            return 'DETERMINED', 'mass and centre of mass are determined'
        open_ = [name for name, done in zip(('mass', 'x', 'y', 'z'), determined) if not done]
        return 'ESTIMATING', f'not determined yet: {", ".join(open_)}'

    def _why_waiting(self):
        """Return in words why no motion was seen, or too little."""
        if self._restored:
            return (f'the load is taken {self._restored}; {self._moved:.1f} s of motion since, '
                    f'and {CONFIRMED_AFTER:g} s confirm or refute it')
        rejected = joint_states_of(self._stream.rejected)
        if sum(rejected.values()) > self.samples:
            return (f'most joint states are rejected: {in_words(rejected)}; no joint that carries '
                    'the load moves in the others')
        return 'no joint that carries the load has moved: at rest friction hides it'

    def _determined(self, belief):
        """Return (10,) bool: what is known as well as users asked, by motion and not by rest."""
        seen = self._began and not self._restored
        return seen & (np.sqrt(belief.covariance.diagonal()) < self._thresholds)

    def _say(self, stamp, belief, status, reason, determined):
        belief = published(belief, self.method)
        return LoadEstimate(stamp, belief.mean, belief.covariance, determined, status, reason,
                            self.load_id)


def _joined(*reasons):
    return '; '.join(filter(None, reasons))
