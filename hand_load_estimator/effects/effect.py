"""What an effect of the torque model is: physics, parameters and regressor columns."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .smooth_sign import sign_of

# [rad/s] Slower motion tells nothing of friction: noise and presliding hide its direction.
SLOWEST = 0.01


@dataclass(frozen=True)
class EffectInput:
    """
    What the columns of an effect may depend on, (N, n) each.

    q [rad], v [rad/s], a [rad/s^2]; warmth: joint temperature less the reference [K], 0 where
    it is not measured; z: friction of size one as the filter shows it (shown_friction.py);
    at_once: what z would be of contacts that turn at once, where q, v and a come through the
    motion filter. Only where an effect of the model needs them: gear [Nm]: torque of links,
    load and what pulls on them, gear_way [Nm]: how far it goes either way within the motion
    filter; drive [Nm]: torque of the drive; rate [Nm/s]: how fast it changes, for pictures;
    tilt(): torque of turning gravity about Robot.tilt_axes, (N, n, 2) [Nm/rad]; late(delays):
    torque of the drive so many seconds ago less the torque now, (N, n) for a delay or delays
    (n,); play(j, travel, lag, pose_share, impact): what a gap [rad] in the gear of joint j
    does to the torque of its drive (play.py), (N,) [Nm], or (N, m) for arrays of m joints,
    gaps, lags [s], shares [-] and impacts [s]; shown(j, travel, plastic, *peak): friction of
    size one as the motion filter shows it (shown_friction.py), (N,) or (N, m) [-], peak: of
    stribeck_curve.left; jerk [rad/s^3] where q, v and a come through the motion filter.
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    warmth: np.ndarray
    z: np.ndarray
    gear: np.ndarray | None = None
    gear_way: np.ndarray | None = None
    drive: np.ndarray | None = None
    rate: np.ndarray | None = None
    tilt: Callable | None = None
    late: Callable | None = None
    play: Callable | None = None
    shown: Callable | None = None
    jerk: np.ndarray | None = None
    at_once: np.ndarray | None = None

    @cached_property
    def sign(self):
        """Friction of size one (N, n) that turns at once: smoothed, or as the filter shows it."""
        return sign_of(self.v) if self.at_once is None else self.at_once


def side_by_side(*columns):
    """Return (..., k) of k columns (...); a stack without its price for small ones."""
    out = np.empty(columns[0].shape + (len(columns),))
    for k, column in enumerate(columns):
        out[..., k] = column
    return out


# [-] So near an end of a shape a search may stop: the last steps to it gain hardly a nat.
AT_END = 0.05


@dataclass(frozen=True)
class Shape:
    """
    A parameter the columns depend on nonlinearly: searched over `grid`, then kept.

    An empty grid: it is found from the residual (the period of a ripple). gain [nats]: what
    another value must explain more than the default does, which is then no such shape, as
    infinity is; least, most: no search goes beyond them.
    """

    name: str
    unit: str
    default: float
    grid: tuple
    gain: float = 0.0
    least: float = 0.0
    most: float = np.inf

    def slowest(self, value):
        """Tell whether a value stands at the lower end of a speed, which no motion goes below."""
        return self.unit == 'rad/s' and value <= (1.0 + AT_END) * self.least

    def longest(self, value):
        """Tell whether a value stands at the upper end, unless it does so by default."""
        return self.default != self.most and value >= (1.0 - AT_END) * self.most

    def there(self, value):
        """Tell whether a value says anything: infinite, or not worth its price, it is plain."""
        return bool(np.isfinite(value) and not (self.gain and value == self.default))


@dataclass(frozen=True)
class Effect:
    """
    One physical effect, linear in its parameters.

    parameters: (name, unit) each; prior_std: as many standard deviations, in fractions of the
    joint's maximum torque per unit, or `absolute`; positive: parameters (by number) that physics
    allows no other sign, of changes their sum with what was there; of_warmth: those that move
    nothing at the reference temperature; columns(x, j, shape) ->
    (N, k) for joint j, where shape maps names of `shapes` to values; for an array of m joints and
    arrays of values, (N, m, k).
    in_link_torque: whether a sensor behind the gear sees it. against: the variable it is a
    function of, as a picture shows it. default: declared by `identify` unless told otherwise.
    learned: a function without physics, never searched for. whole_arm: one set of parameters
    moves all joints. derived(values, shape) -> {name: (value, unit)}: what an engineer calls the
    parameters, or None.
    """

    name: str
    physics: str
    source: str
    parameters: tuple
    prior_std: tuple
    columns: Callable
    shapes: tuple = ()
    in_link_torque: bool = False
    against: str = 'velocity'
    default: bool = False
    whole_arm: bool = False
    absolute: bool = False
    learned: bool = False
    positive: tuple = ()
    of_warmth: tuple = ()
    derived: Callable | None = None
    # Whether it pulls on the link, through the gear; a leaning base, which does, reads tilt.
    pulls: bool = False
    # Fields of EffectInput, beside motion and friction state, that the columns read.
    needs: frozenset = frozenset()

    def std(self, torque):
        """Return the prior's standard deviations (k,) for a joint of maximum torque [Nm]."""
        return np.array(self.prior_std) * (1.0 if self.absolute else torque)

    def told(self, shape):
        """Return those of the values {name: value} of a shape that say anything."""
        return {s.name: shape[s.name] for s in self.shapes if s.there(shape[s.name])}

    def bounded(self, shape):
        """Return the values {name: value} of a shape, none beyond what a search may reach."""
        return shape | {s.name: min(max(shape[s.name], s.least), s.most) for s in self.shapes
                        if s.name in shape}

    def default_shape(self):
        """Return the mapping of shape names to defaults."""
        return {s.name: s.default for s in self.shapes}


@dataclass(frozen=True)
class Described:
    """
    A name of the vocabulary that is no Effect: it adds no columns of its own to a model.

    parameters: (name, unit) each, as reports give them.
    """

    name: str
    physics: str
    source: str
    parameters: tuple


def amplitude_and_angle(sine, cosine):
    """Return amplitude k and angle of rest q0 of k sin(q - q0) = sine sin q + cosine cos q."""
    return np.hypot(sine, cosine), np.arctan2(-cosine, sine)
