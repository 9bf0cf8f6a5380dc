"""Coloured noise of some runs, in which something may ring."""

import numpy as np

STEP, SECONDS, JOINTS = 0.02, 40.0, 3
NEEDED = 100.0   # [nats]


def recorded(seed, memory=0.5, runs=4):
    """Return coloured noise (N, JOINTS), slow speeds alike, dt, owner and time of some runs."""
    rng = np.random.default_rng(seed)
    count = int(SECONDS / STEP) * runs
    noise, keep = rng.normal(size=(count, JOINTS)), np.exp(-STEP / memory)
    for k in range(1, count):
        noise[k] += keep * noise[k - 1]
    time = STEP * np.arange(count)
    speed = np.sin(2.0 * np.pi * 0.2 * time)[:, None] * np.ones(JOINTS)
    return noise, speed, np.full(count, STEP), np.arange(count) // (count // runs), time
