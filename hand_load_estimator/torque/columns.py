"""
The columns Y of the torque model: what every parameter of links and effects does to the torque.

tau_mdl = Y(theta, theta', theta'') x. The same columns serve identification (eq. 11), prediction
(E1.1) and the model's own uncertainty at run time.
"""

from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from ..effects import EFFECTS, LATE
from ..effects.knee import KNEE
from ..effects.own_travel import BOTH
from .lateness import lateness
from .link_pull import link_pull
from .play import PlayAlong
from .shown_links import shown_links_and_way


# Used for joints whose model declares no presliding: friction turns within encoder resolution.
NO_PRESLIDING = 1e-4


@dataclass(frozen=True)
class EffectUse:
    """
    One declared effect on one joint: its name, joint index and shape values.

    An effect of the whole arm stands at joint 0. Shapes that are not given have their defaults;
    shape_std: standard deviations of those that were estimated with the parameters, or that a
    diagnosis states.
    """

    name: str
    joint: int
    shape: dict = field(default_factory=dict)
    shape_std: dict = field(default_factory=dict)

    def __post_init__(self):
        """Complete the shape."""
        object.__setattr__(self, 'shape', {**self.effect.default_shape(), **self.shape})

    @property
    def effect(self):
        """The Effect of that name."""
        return EFFECTS[self.name]

    @property
    def told_shape(self):
        """The shape values that are there (Shape.there)."""
        return self.effect.told(self.shape)

    @property
    def formula(self):
        """The shape values that a search chose: a knee is estimated with the parameters."""
        return {name: value for name, value in self.told_shape.items() if name != KNEE.name}


def warmth_of(robot, temperature):
    """Return temperature less reference [K], 0 where it is NaN."""
    warmth = temperature - robot.reference_temperature
    return np.where(np.isnan(warmth), 0.0, warmth)


def effect_slices(n, uses):
    """Return (EffectUse, slice of x) pairs for the layout of `uses` behind n links."""
    start, pairs = 10 * n, []
    for use in uses:
        stop = start + len(use.effect.parameters)
        pairs.append((use, slice(start, stop)))
        start = stop
    return pairs


def first_of_joints(n, uses, name, values):
    """Return an effect's first entries (n,) of values (P,), zero for joints without it."""
    out = np.zeros(n)
    for use, where in effect_slices(n, uses):
        if use.name == name:
            out[use.joint] = values[where.start]
    return out


def parameter_count(n, uses):
    """Return P, the length of x."""
    return 10 * n + sum(len(use.effect.parameters) for use in uses)


def presliding_distances(n, uses):
    """Return the presliding travel (n,) [rad] of the joints."""
    distance = np.full(n, NO_PRESLIDING)
    for use in uses:
        if use.name == 'presliding_hysteresis':
            distance[use.joint] = use.shape['presliding_distance']
    return distance


def presliding_plastics(n, uses):
    """Return of which last of the way between two levels (n,) each joint's contacts yield."""
    plastic = np.full(n, BOTH)
    for use in uses:
        if use.name == 'presliding_hysteresis':
            plastic[use.joint] = use.shape['plastic']
    return plastic


def effect_columns(x, use):
    """Return the columns (N, k) of one effect on its joint."""
    return use.effect.columns(x, use.joint, use.shape)


class ColumnLayout:
    """
    Where the columns of declared effects stand in Y, joints of one effect taken together.

    size: P, the length of x. needs: what the columns read beside motion and friction state; pulls:
    whether there are springs or cables.
    prompt (P,): which are of no delay: a delay delays all of these; late: numbers of the others.
    """

    def __init__(self, n, uses):
        self.size, self.links = parameter_count(n, uses), 10 * n
        pairs = effect_slices(n, uses)
        plain, geared, scaled, late = [], [], [], []
        for name in dict.fromkeys(use.name for use in uses):
            effect = EFFECTS[name]
            own = [(use, where) for use, where in pairs if use.name == name]
            joints = np.array([use.joint for use, _ in own])
            shape = {s: np.array([use.shape[s] for use, _ in own]) for s in own[0][0].shape}
            places = np.array([range(where.start, where.stop) for _, where in own])
            if effect.whole_arm:
                joints = np.arange(n)
            group = effect, joints, shape, places
            (late if name == LATE else scaled if 'drive' in effect.needs
             else geared if effect.needs & _TORQUES else plain).append(group)
        self._plain, self._geared, self._scaled, self._late = (
            _Groups(groups, n) for groups in (plain, geared, scaled, late))
        self._pulling = _Groups([group for group in plain if group[0].pulls], n)
        self.pulls = len(self._pulling.places) > 0
        self.prompt = np.ones(self.size, dtype=bool)
        self.late = np.sort(self._late.places)
        self.prompt[self.late] = False
        self.needs = frozenset().union(*(EFFECTS[use.name].needs for use in uses)) & _TORQUES
        self._tilt = next((where for use, where in pairs if use.name == 'base_tilt'), None)

    def fill(self, columns, x):
        """Write the effects that motion and friction state suffice for into columns (N, n, P)."""
        self._plain.fill(columns, x)

    def fill_geared(self, columns, x):
        """Write the effects that depend on torques behind the drive into columns (N, n, P)."""
        self._geared.fill(columns, x)

    def fill_scaled(self, columns, x):
        """Write what depends on all that drives give into columns (N, n, P)."""
        self._scaled.fill(columns, x)

    def pull(self, x, mean):
        """Return the torque (N, n) [Nm] of springs and cables at an EffectInput."""
        columns = np.zeros(x.q.shape + (self.size,))
        self._pulling.fill(columns, x)
        return columns @ mean

    def fill_late(self, columns, x):
        """Write delays into columns (N, n, P)."""
        self._late.fill(columns, x)

    def tilt(self, mean):
        """Return the angles (2,) [rad] of a leaning base in x (P,)."""
        return np.zeros(2) if self._tilt is None else mean[self._tilt]

    def prompt_torque(self, columns, mean):
        """Return the torque (N, n) [Nm] that delays delay."""
        return columns @ np.where(self.prompt, mean, 0.0)


# Inputs of effects that follow from the other columns.
_TORQUES = frozenset({'gear', 'gear_way', 'drive', 'tilt', 'late', 'play'})


class _Groups:
    """
    Groups of (effect, joints (m,), shape, places in x (m or 1, k)) that are written together.

    places: all of theirs, in a row.
    """

    def __init__(self, groups, n):
        # A slice spares columns of all joints the copy that an index makes; what depends on
        # torques wants the numbers.
        self._groups = [
            (effect, slice(None) if np.array_equal(joints, np.arange(n))
             and not effect.needs & _TORQUES else joints, shape)
            for effect, joints, shape, _ in groups]
        pairs = [np.broadcast_arrays(joints[:, None], places) for _, joints, _, places in groups]
        self._joints, self.places = (np.concatenate([p[k].ravel() for p in pairs]).astype(int)
                                     if pairs else np.zeros(0, dtype=int) for k in range(2))

    def fill(self, columns, x):
        """Write the effects into columns (N, n, P)."""
        if self._groups:
            columns[:, self._joints, self.places] = np.concatenate(
                [effect.columns(x, joints, shape).reshape(len(columns), -1)
                 for effect, joints, shape in self._groups], axis=1)


def torque_columns(robot, layout, x, mean=None, dt=None, load=None, before=None,
                   teeth=(None, 0.0), links=None):
    """
    Return Y (N, n, P) for a ColumnLayout and an EffectInput.

    Only for layouts with effects that depend on torques: mean (P,) tells them; dt (N,) [s]
    between the samples, without which torques stand still; load: LoadParameters that drives and
    gears are known to carry too, or None; before: (torque (M, n) [Nm], dt (M,) [s]):
    what `prompt_torque` was at the samples before the first; teeth: (PlayState (n) of the gears
    there, carried on; torque (n,) [Nm] that a load which is believed to be held adds); links:
    shown_links_and_way of x, where they are known.
    """
    count, n = x.q.shape
    columns = np.zeros((count, n, layout.size))
    columns[:, :, :layout.links], way = links or shown_links_and_way(robot, x)
    layout.fill(columns, x)
    if layout.needs:
        gear, gear_way = gear_torque(robot, columns[:, :, :layout.links], way, mean, load)
        held = gear - columns[:, :, :layout.links] @ mean[:layout.links]
        carried = None if load is None else load.to_products()
        tilt = tilt_along(robot, layout, x.q, mean, carried) if 'tilt' in layout.needs else None
        pull, pull_way = link_pull(layout, x, mean, tilt)
        gear, gear_way = gear + pull, gear_way + pull_way
        x = replace(
            x, gear=gear, gear_way=gear_way, tilt=tilt,
            play=play_columns(robot, x.q, gear, dt, teeth) if 'play' in layout.needs else None)
        layout.fill_geared(columns, x)
        layout.fill_scaled(columns, replace(x, drive=columns @ mean + held))
        if 'late' in layout.needs:
            # What is read wrong, or leans, is read late with everything else.
            layout.fill_late(columns, replace(x, late=lateness(
                layout.prompt_torque(columns, mean) + held, dt, before)))
    return columns


def gear_torque(robot, links, way, mean, load=None):
    """
    Return (N, n) [Nm] twice: torque of links and load, and how far it goes within the filter.

    links, way: of shown_links_and_way; other arguments as of torque_columns. Gears carry
    link_pull, too.
    """
    gear, gear_way = (columns @ mean[:columns.shape[-1]] for columns in (links, way))
    if load is not None and load.mass > 0.0:
        gear, gear_way = (torque + robot.load_columns(columns) @ load.to_products()
                          for torque, columns in ((gear, links), (gear_way, way)))
    return gear, gear_way


def play_columns(robot, q, gear, dt, teeth=(None, 0.0)):
    """
    Return play(joints, travels, lags, pose_shares, impacts) of EffectInput at q (N, n).

    gear (N, n) [Nm]: torque of the gears; the links' inertias are the robot file's. teeth: as of
    torque_columns.
    """
    if dt is None:
        return lambda joints, *_: np.zeros((len(q), *np.shape(joints)))
    inertia = np.array([np.diag(robot.mass_matrix(row)) for row in q])
    states, believed = teeth
    return PlayAlong(((gear + believed, inertia, dt),), robot.usual_inertia, states)


def tilt_along(*arguments):
    """Return tilt() of EffectInput, computed where it is asked for; arguments of tilt_columns."""
    return cache(partial(tilt_columns, *arguments))


def tilt_columns(robot, layout, q, mean, load=None, turn=0.0):
    """
    Return (N, n, 2) [Nm/rad]: torque of turned gravity at positions q (N, n).

    x (P,) of a ColumnLayout tells the links, and the turn that the columns are exact for; turn
    (2,) [rad]: beyond that; load: products (10,) that are known to be held, or None.
    """
    links, angles = mean[:layout.links].copy(), layout.tilt(mean) + turn
    if load is not None:
        # The load is fixed to the last link.
        links[-10:] += robot.in_last_link(load)
    return np.array([robot.tilt_regressor(row, links, angles) for row in q])


def real_torque(robot, q, effort):
    """
    Return tau_real (n,) [Nm] of efforts (n,) as reported (E1.2).

    Current times torque constant; the configured load the controller has already taken off is
    put back, as its gravity torque.
    """
    return effort * robot.effort.torque_constants + robot.configured_torque(q)
