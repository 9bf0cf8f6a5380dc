"""Follow several recordings in lock-step: a step costs about the same for a few and for many."""

import numpy as np


def lock_step(parts, follow):
    """
    Return what `follow` makes of parts, a list of arrays (N, ..., k).

    parts: tuples of arrays (N, ..., any). follow(numbers, rows) gets the numbers of parts of like
    length and, of each of their arrays, (L, ..., any of all) with the parts side by side; the
    last rows of shorter ones are repeated, and what comes of them cut off. It returns
    (L, ..., k of all).
    """
    found = [None] * len(parts)
    for numbers in _of_like_length([len(part[0]) for part in parts]):
        out = follow(numbers, _side_by_side([parts[k] for k in numbers]))
        width = out.shape[-1] // len(numbers)
        for place, k in enumerate(numbers):
            found[k] = out[:len(parts[k][0]), ..., place * width:(place + 1) * width]
    return found


def _of_like_length(lengths):
    """Return lists of numbers: none is shorter than half of the longest beside it."""
    groups = []
    for k in sorted(range(len(lengths)), key=lambda k: -lengths[k]):
        if groups and 2 * lengths[k] >= lengths[groups[-1][0]]:
            groups[-1].append(k)
        else:
            groups.append([k])
    return groups


def _side_by_side(parts):
    longest = max(len(part[0]) for part in parts)
    return [np.concatenate([_as_long(rows, longest) for rows in own], axis=-1)
            for own in zip(*parts)]


def _as_long(rows, count):
    missing = count - len(rows)
    return np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)]) if missing else rows
