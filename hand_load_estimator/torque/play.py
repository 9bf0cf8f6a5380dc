"""
Play: what a gap between the teeth of a gear does to the torque of its drive.

Two bodies and a dead zone with rigid teeth (Nordin and Gutman 2002, section 2). While the teeth
touch, the drive carries the link. When the torque through the gear changes sign they part: the
drive carries nothing, and the link, left to itself, falls behind or runs ahead of it,
p'' = torque / inertia for the angle p by which the drive leads. On the other side of the gap the
teeth meet and the drive takes the link's momentum, within the time that they need to bend. So a
crossing spares the drive a torque and returns all of its integral with the impact.

The inertia decides how long a crossing takes. With the other joints held firmly it is the mass
matrix's, which an arm's pose changes many times over; joints behind that give way hide the pose.
How much of the pose shows is therefore a figure of the gap, like its travel.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..motion import BANDWIDTH, filter_step
from .lock_step import lock_step

# Steps of a crossing within a sample: two milliseconds at the motion filter's rate.
STEPS = 10
_MIDDLES = ((np.arange(STEPS) + 0.5) / STEPS)[:, None]
# One of the motion filter's stages, and all of them, delay by this [s].
STAGE = 1.0 / BANDWIDTH
FILTER_DELAY = 3.0 * STAGE
# Times between samples are rounded to this [s], so that jitter makes no end of filters.
ROUNDED = 1e-4
# A robot file may state no inertia [kg m^2]: a link with hardly any is across at once.
LEAST_INERTIA = 1e-12
# Of an impact less than this [Nm] is nothing any more.
LEAST_IMPACT = 1e-3


@lru_cache(maxsize=4096)
def _filter(count):
    """Return (3, 3) and (3, STEPS): the motion filter over `count` ROUNDED, inputs held a step."""
    matrix, before, now = filter_step(max(count, 1) * ROUNDED / STEPS)
    powers = [np.linalg.matrix_power(matrix, k) for k in range(STEPS, -1, -1)]
    return powers[0], np.stack([p @ (before + now) for p in powers[1:]], axis=1)


def _shown(stages, felt, dt):
    """Return the filter's stages (3, m) after dt [s] or (m,) under felt (STEPS, m) or None."""
    if np.ndim(dt) == 0:
        matrix, gains = _filter(round(dt / ROUNDED))
        return matrix @ stages + (0.0 if felt is None else gains @ felt)
    out = np.empty_like(stages)
    for step in np.unique(dt):
        own = dt == step
        out[:, own] = _shown(stages[:, own], None if felt is None else felt[:, own], step)
    return out


def crossing_inertia(inertia, usual, pose_share):
    """
    Return the inertia [kg m^2] that crosses a gap.

    inertia: the link's at its pose; usual: its mean over poses; pose_share [-]: 1 when all of the
    pose shows, near 0 when none does.
    """
    inertia, usual = np.maximum(inertia, LEAST_INERTIA), np.maximum(usual, LEAST_INERTIA)
    return usual * (inertia / usual) ** pose_share


class PlayState:
    """
    Follow gaps (m,), and what their drives feel of them as the motion filter shows it.

    Each starts with the teeth together on the side that its torque pushes to. They may be of
    several joints, or what one joint might have.
    """

    def __init__(self):
        self._torque = None  # [Nm] shown by the filter

    def _start(self, torque, half):
        self._torque, m = torque, len(half)
        self._ahead = torque  # as the teeth have it
        self._rate = None
        self._place, self._speed = np.copysign(half, torque), np.zeros(m)
        self._apart, self._impact = np.zeros(m, dtype=bool), np.zeros(m)
        self._shown = np.zeros((3, m))

    def update(self, torque, inertia, travel, lag, impact, dt):
        """
        Return the torque (m,) [Nm] that play adds to the drives', after dt [s] or (m,).

        torque (m,) [Nm] that the gears have to carry, of the filtered motion; inertia (m,)
        [kg m^2] that crosses; travel (m,) [rad] of the gap; lag (m,) [s] of the torque between the
        teeth behind it, a first-order one, by which they part late; impact (m,) [s]: time constant
        in which the teeth take the link's momentum.
        """
        half = 0.5 * travel
        if self._torque is None:
            self._start(torque, half)
            return self._shown[2]
        before, ahead = self._ahead, self._at_the_teeth(torque, lag, dt)
        moved = (self._apart | (before * self._place < 0.0) | (ahead * self._place < 0.0)
                 | (self._impact != 0.0)).nonzero()[0]
        felt = None
        if len(moved):
            # Of many gaps that are followed at once few cross at the same time.
            felt = np.zeros((STEPS, len(half)))
            felt[:, moved] = self._cross(moved, before[moved], ahead[moved], inertia[moved],
                                         half[moved], impact[moved],
                                         dt if np.ndim(dt) == 0 else dt[moved])
        self._shown = _shown(self._shown, felt, dt)
        return self._shown[2]

    def _at_the_teeth(self, torque, lag, dt):
        """Return the torque (m,) [Nm] that parts the teeth now."""
        rate = (torque - self._torque) / dt
        bend = 0.0 if self._rate is None else (rate - self._rate) / dt
        self._torque, self._rate = torque, rate
        # What the filter shows is late: all of it taken off and the lag put on, (1 + STAGE s)^3
        # over 1 + lag s, to second order.
        lead = FILTER_DELAY - lag
        self._ahead = torque + lead * rate + (3.0 * STAGE ** 2 - lag * lead) * bend
        return self._ahead

    def _cross(self, moved, before, ahead, inertia, half, impact, dt):
        """
        Return the mean torques (STEPS, k) of the gaps `moved` (k,) over the steps of a sample.

        before, ahead (k,) [Nm]: the links' torques at its ends, between which they are held
        constant over a step; the rest as of update.
        """
        place, speed, apart, left = (values[moved] for values in (
            self._place, self._speed, self._apart, self._impact))
        step, torques = dt / STEPS, before + _MIDDLES * (ahead - before)
        # Share of an impact that is left after a step, and of its momentum that a step takes.
        keep, gain = np.exp(-step / impact), step / inertia
        taken, carried = (1.0 - keep) / gain, (1.0 - keep) * torques
        felt, half_step, other = np.empty_like(torques), 0.5 * step, -half
        for k, (torque, hit, push) in enumerate(zip(torques, carried, gain * torques)):
            parted = apart | (torque * place < 0.0)
            faster = speed + push
            there = place + half_step * (speed + faster)
            apart = parted & (np.abs(there) < half)
            # What was apart, or parts, and does not fly has struck.
            left = keep * left + (parted ^ apart) * (taken * faster - hit)
            place = np.where(parted, np.minimum(np.maximum(there, other), half), place)
            speed = apart * faster
            felt[k] = left - apart * torque
        self._place[moved], self._speed[moved], self._apart[moved] = place, speed, apart
        self._impact[moved] = np.where(np.abs(left) > LEAST_IMPACT, left, 0.0)
        return felt


@dataclass(frozen=True)
class PlayAlong:
    """
    play(joints, travels, lags, pose_shares, impacts) of EffectInput along recordings.

    parts: (torque [Nm], inertia [kg m^2] (N, n), dt (N,) [s]) of each, one after the other;
    inertia: the links' along it; usual (n,): its mean over poses. Arguments of a call as of
    PlayState.update: for one joint (N,), for arrays of m joints (N, m), which may hold a joint
    several times. states: PlayState (n) to carry on along one recording; new ones without.
    """

    parts: tuple
    usual: np.ndarray
    states: list | None = None

    def __call__(self, joints, *gaps):
        several = np.broadcast_arrays(*map(np.atleast_1d, (joints, *gaps)))
        follow = self._along if self.states is None else self._carried_on
        found = follow(*several)
        return found[:, 0] if np.ndim(joints) == 0 else found

    def off_usual(self, joint):
        """Return the logarithm (N,) [-] of a joint's inertias along it over its usual."""
        inertia = np.concatenate([own[:, joint] for _, own, _ in self.parts])
        usual = max(self.usual[joint], LEAST_INERTIA)
        return np.log(np.maximum(inertia, LEAST_INERTIA) / usual)

    def _carried_on(self, joints, *gaps):
        """Return what gaps (m,) do along the one part, from the states on: (N, m)."""
        ((torque, inertia, dt),) = self.parts
        found = np.zeros((len(dt), len(joints)))
        for j in set(joints.tolist()):
            own = joints == j
            travel, lag, share, impact = (values[own] for values in gaps)
            moved = crossing_inertia(inertia[:, [j]], self.usual[j], share)
            found[:, own] = [self.states[j].update(tau, mine, travel, lag, impact, step)
                             for tau, mine, step in zip(torque[:, [j]].repeat(own.sum(), axis=1),
                                                        moved, dt)]
        return found

    def _along(self, joints, travel, lag, share, impact):
        """Return what gaps (m,) do along all parts, one after the other: (N, m)."""
        usual, m = np.asarray(self.usual)[joints], len(joints)

        def follow(numbers, rows):
            own, count = PlayState(), len(numbers)
            gaps = [np.tile(values, count) for values in (travel, lag, impact)]
            return np.array([
                own.update(torque, inertia, *gaps,
                           dt[0] if (dt == dt[0]).all() else np.repeat(dt, m))
                for torque, inertia, dt in zip(*rows)])

        return np.concatenate(lock_step(
            [(torque[:, joints], crossing_inertia(inertia[:, joints], usual, share), dt[:, None])
             for torque, inertia, dt in self.parts], follow))
