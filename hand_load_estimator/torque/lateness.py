"""What comes late: torque as it was some seconds ago, and what belongs to it."""

import numpy as np

from ..effects import LATE


def lateness(torque, dt, before=None):
    """
    Return late(delays): torque (N, n) [Nm] some seconds ago less the torque now.

    torque (N, n) at samples dt (N,) [s] apart; before: (torque (M, n), dt (M,)) ahead of them;
    without dt it stands still. delays [s]: one, or (n,).
    """
    if dt is None:
        return lambda delays: np.zeros_like(torque)
    past, gaps = (torque[:0], np.zeros(0)) if before is None else before
    series = np.concatenate([past, torque])
    time = np.cumsum(np.concatenate([gaps, dt]))

    def late(delays):
        delays = np.broadcast_to(delays, series.shape[1])
        now = time[len(past):]
        return np.stack([np.interp(now - delay, time, column) for delay, column in
                         zip(delays, series.T)], axis=1) - torque
    return late


def change_when_late(values, dt, owner, delays):
    """
    Return what delays [s], one or (k,), change of values (N, k) at samples dt (N,) [s] apart.

    owner (N,): part of a recording that each belongs to, in a row; none is the past of the next.
    """
    starts = np.flatnonzero(np.diff(owner)) + 1
    return np.concatenate([lateness(own, gaps)(delays) for own, gaps in
                           zip(np.split(values, starts), np.split(dt, starts))])


def as_reported(uses, values, dt, owner):
    """
    Return values (N, n) of the moments that the torques reported at N samples belong to.

    A joint with a delay among EffectUses moves already when the torque of its rest is reported.
    dt, owner: as of change_when_late.
    """
    delays = np.zeros(values.shape[1])
    for use in uses:
        if use.name == LATE:
            delays[use.joint] = use.shape['shift']
    return values + change_when_late(values, dt, owner, delays) if delays.any() else values
