"""Random motions for training: moves with dwells, unequal ramps, some joints at rest, waves."""

import numpy as np


def _ramp_profile(t, up, flat, down):
    """Return progress (0 to 1), its rate and its acceleration of a trapezoid in velocity."""
    peak = 1.0 / (0.5 * up + flat + 0.5 * down)
    t = np.clip(t, 0.0, up + flat + down)
    a = np.where(t < up, peak / up, np.where(t < up + flat, 0.0, -peak / down))
    late = np.maximum(t - up - flat, 0.0)
    v = np.where(t < up, peak * t / up, peak) - peak * late / down
    s = np.where(t < up, 0.5 * peak * t ** 2 / up, 0.5 * peak * up + peak * (t - up))
    return s - 0.5 * peak * late ** 2 / down, v, a


def _smooth_profile(t, total):
    """Return progress, rate and acceleration of a quintic from rest to rest."""
    u = np.clip(t / total, 0.0, 1.0)
    inside = (t >= 0.0) & (t <= total)
    return (u ** 3 * (10 - 15 * u + 6 * u * u), inside * 30 * u ** 2 * (1 - u) ** 2 / total,
            inside * 60 * u * (1 - u) * (1 - 2 * u) / total ** 2)


def _range(limits):
    """Return low, high (n,) [rad] within the limits and within 2.6 rad of the nearest to zero."""
    middle = np.clip(0.0, limits.lower, limits.upper)
    return np.maximum(limits.lower, middle - 2.6), np.minimum(limits.upper, middle + 2.6)


def random_moves(rng, robot, times):
    """Return q, v, a (N, n) of point-to-point moves with dwells along times (N,) [s]."""
    n, limits = robot.n, robot.limits
    low, high = _range(limits)
    speed = rng.uniform(0.15, 1.0)
    here = rng.uniform(low, high)
    q = np.tile(here, (len(times), 1))
    v, a = np.zeros_like(q), np.zeros_like(q)
    start = rng.uniform(0.15, 1.0)
    while start < times[-1]:
        reach = rng.choice([0.15, 0.5, 1.2])
        goal = np.clip(here + rng.normal(0.0, reach, n), low, high)
        goal = np.where(rng.random(n) < rng.choice([0.0, 0.3, 0.6]), here, goal)
        way = goal - here
        fast = speed * rng.uniform(0.6, 1.0)
        cruise = np.max(np.abs(way) / (fast * limits.velocity)) + 1e-3
        ramp = np.sqrt(np.max(np.abs(way) / (fast * limits.acceleration)) + 1e-4)
        up, down = np.maximum(ramp, 0.05) * rng.uniform(0.7, 1.8, 2)
        flat = max(0.02, cruise - 0.5 * (up + down))
        total = up + flat + down
        t = times - start
        inside = (t >= 0.0) & (t <= total)
        if rng.random() < 0.6:
            s, ds, dds = _ramp_profile(t, up, flat, down)
        else:
            s, ds, dds = _smooth_profile(t, total)
        q += np.outer(np.where(t >= 0.0, s, 0.0), way)
        v += np.outer(inside * ds, way)
        a += np.outer(inside * dds, way)
        here = goal
        start += total + rng.choice([0.0, 0.1, 0.5, 1.5]) * rng.random()
    return q, v, a


def random_waves(rng, robot, times):
    """Return q, v, a (N, n) of a sum of waves that grows out of rest, as identification uses."""
    n, limits = robot.n, robot.limits
    low, high = _range(limits)
    begin = rng.uniform(0.15, 1.0)
    t = np.maximum(times - begin, 0.0)
    w = 2.0 * np.pi * rng.uniform(0.05, 0.35, (4, n))
    size, phase = rng.normal(size=(4, n)), rng.uniform(0.0, 2.0 * np.pi, (4, n))
    angle = w * t[:, None, None] + phase
    wave = [np.sum(size * f, axis=1) for f in (
        np.sin(angle), w * np.cos(angle), -w * w * np.sin(angle))]
    # Fade in over a second so that position, velocity and acceleration start from rest.
    u = np.clip(t, 0.0, 1.0)[:, None]
    fade = u ** 3 * (10 - 15 * u + 6 * u * u)
    dfade, ddfade = 30 * u ** 2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)
    q = fade * wave[0]
    v = fade * wave[1] + dfade * wave[0]
    a = fade * wave[2] + 2.0 * dfade * wave[1] + ddfade * wave[0]
    scale = rng.uniform(0.2, 0.95) * min(
        np.min(limits.velocity / np.maximum(np.abs(v).max(axis=0), 1e-6)),
        np.min(limits.acceleration / np.maximum(np.abs(a).max(axis=0), 1e-6)),
        np.min(0.3 * (high - low) / np.maximum(np.abs(q).max(axis=0), 1e-6)))
    centre = low + (high - low) * rng.uniform(0.3, 0.7, n)
    return centre + scale * q, scale * v, scale * a


def random_motion(rng, robot, times):
    """Return q, v, a (N, n): mostly moves with dwells, sometimes waves."""
    maker = random_moves if rng.random() < 0.75 else random_waves
    return maker(rng, robot, times)
