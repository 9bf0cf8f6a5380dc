"""Temperatures of a recording that stopped coming, or came late."""

from dataclasses import replace

import numpy as np


def bridged(motion):
    """
    Return a Motion whose joints have at all times a temperature that they had at one.

    A joint warms by a few kelvin in minutes: between two readings it goes evenly, before the first
    and after the last it stays. Unknown it would count as the reference temperature.
    """
    known = np.isfinite(motion.temperature)
    gaps = np.flatnonzero(known.any(axis=0) & ~known.all(axis=0))
    if not len(gaps):
        return motion
    temperature, stamp = motion.temperature.copy(), motion.stamp
    for j in gaps:
        there = known[:, j]
        temperature[:, j] = np.interp(stamp, stamp[there], temperature[there, j])
    return replace(motion, temperature=temperature)
