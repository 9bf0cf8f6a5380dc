"""Contacts: short bursts of residual that one force at the hand explains."""

import numpy as np

from .diagnosis import CONFIRMED, SUSPECTED, Evidence, Finding, Picture

WINDOW = 0.24            # [s]
# A burst's mean over the window, squared and summed over joints in units of its variance.
LEAST, TIMES_USUAL = 60.0, 8.0
MOST_OF_THE_TIME = 0.1
SHORTEST = 0.1           # [s]
EXPLAINED = 0.6          # share of a burst that the force must explain


def contacts_in(robot, residual, rest, trials):
    """Return (rows (N,) bool in contact, Findings) from what is left (N, n) [Nm] of a Residual."""
    rows = _bursts(residual, rest)
    found, kept = [], np.zeros(len(rest), dtype=bool)
    for first, last in _spans(rows, residual.owner):
        span = slice(first, last)
        if residual.dt[span].sum() < SHORTEST:
            continue
        force, std, share, gain = _fit(robot, residual, rest, span)
        if share < EXPLAINED:
            continue
        kept[span] = True
        found.append(_finding(robot, residual, rest, span, (force, std, gain), trials))
    return kept, tuple(found)


def _bursts(residual, rest):
    width = max(3, int(WINDOW / np.median(residual.dt)))
    kernel = np.ones(width)
    chi = np.zeros(len(rest))
    for j in range(rest.shape[1]):
        w = residual.weights[:, j]
        total = np.convolve(w, kernel, 'same')
        chi += np.convolve(w * rest[:, j], kernel, 'same') ** 2 / np.maximum(total, 1e-12)
    rows = (chi > LEAST) & (chi > TIMES_USUAL * np.quantile(chi, 0.95))
    # What is usual is no contact but something the model lacks all the time.
    return rows if rows.mean() < MOST_OF_THE_TIME else np.zeros_like(rows)


def _spans(rows, owner):
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rows.astype(int), [0]])))
    spans = []
    for first, last in zip(edges[::2], edges[1::2]):
        joined = spans and first - spans[-1][1] < 15 and owner[spans[-1][0]] == owner[first]
        if joined:
            spans[-1] = (spans[-1][0], last)
        else:
            spans.append((first, last))
    return spans


def _fit(robot, residual, rest, span):
    """Return force (3,) [N] in base axes, its std, the share explained, gain [nats]."""
    jacobians = np.array([robot.hand_jacobian(q) for q in residual.x.q[span]])
    # What pushes the hand the drives must hold against.
    columns = -np.moveaxis(jacobians, 1, 2)
    w, r = residual.weights[span], rest[span]
    matrix = np.einsum('kja,kj,kjb->ab', columns, w, columns) + 1e-9 * np.eye(3)
    vector = np.einsum('kja,kj,kj->a', columns, w, r)
    covariance = np.linalg.inv(matrix)
    force = covariance @ vector
    whole = float((w * r * r).sum())
    gain = 0.5 * float(vector @ force)
    return force, np.sqrt(np.diag(covariance)), 2.0 * gain / max(whole, 1e-12), gain


def _finding(robot, residual, rest, span, fit, trials):
    force, std, gain = fit
    time = residual.time[span]
    rms = np.sqrt((rest[span] ** 2).mean(axis=0))
    parameters = {f'force_{axis}': (force[k], std[k], 'N') for k, axis in enumerate('xyz')}
    parameters |= {'start': (float(time[0]), WINDOW, 's'),
                   'duration': (float(time[-1] - time[0]), WINDOW, 's')}
    joints = tuple(robot.joints[j] for j in np.flatnonzero(rms > 0.3 * rms.max()))
    main = int(np.argmax(rms))
    around = slice(max(span.start - 50, 0), span.stop + 50)
    zero = np.zeros(len(residual.time[around]))
    drawn = Picture(robot.joints[main], 'time [s]', residual.time[around] - residual.time.min(),
                    rest[around, main], zero, zero, zero, zero)
    return Finding(
        'external_contact', joints, parameters, np.zeros(robot.n),
        # A push happens once: nothing is left to test it on.
        Evidence(np.nan, np.nan, np.nan, len(residual.starts), trials, float(rms.max())), (), '',
        False, CONFIRMED if gain > LEAST else SUSPECTED, (drawn,))
