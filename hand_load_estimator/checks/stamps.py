"""Is the time of the joint states usable: rate, jitter, gaps, order."""

import numpy as np

from .finding import DOUBT, Finding, graded, OK, UNKNOWN, WRONG

# Rates the package is made for (DESIGN section 3).
LOWEST_RATE, HIGHEST_RATE = 30.0, 1000.0
# Logs of 1 kHz loops come out a little above it.
RATE_TOLERANCE = 1.1


def check_stamps(time):
    """Return the findings about header stamps (N,) [s] in recorded order."""
    if len(time) < 10:
        return [Finding('rate', UNKNOWN, f'{len(time)} usable joint states are too few')]
    steps = np.diff(time)
    if not np.any(steps > 0.0):
        text = (f'no header stamp is later than the one before: {_counts(steps)}'
                if np.any(steps) else 'all header stamps are the same')
        return [Finding('rate', WRONG, text, 'let the driver stamp its messages with a clock that '
                        'goes forward')]
    forward = steps[steps > 0.0]
    return [_rate(time, forward), _jitter(forward), _gaps(forward), _order(steps)]


def _rate(time, forward):
    rate = 1.0 / np.median(forward)
    text = f'{rate:.1f} Hz ({len(time)} messages in {time.max() - time.min():.1f} s)'
    if LOWEST_RATE <= rate <= HIGHEST_RATE * RATE_TOLERANCE:
        return Finding('rate', OK, text)
    return Finding('rate', DOUBT, text, f'{LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz are normal; '
                   'change the rate of the joint state broadcaster')


def _jitter(forward):
    period = np.median(forward)
    near = forward[forward < 5.0 * period]
    spread = np.percentile(np.abs(near - period), 95) / period
    text = f'95 % of the steps within {100.0 * spread:.0f} % of {1e3 * period:.2f} ms'
    # Below a millisecond no motion of an arm shows the difference.
    verdict = OK if spread * period < 1e-3 else graded(spread, 0.25, 1.0)
    return Finding('jitter', verdict, text, '' if verdict == OK else
                   'stamp where the joints are read, not where the message is sent')


def _gaps(forward):
    period = np.median(forward)
    gaps = forward[forward > max(5.0 * period, 0.05)]
    if not len(gaps):
        return Finding('gaps', OK, f'none; longest step {1e3 * forward.max():.1f} ms')
    share = gaps.sum() / forward.sum()
    return Finding('gaps', DOUBT if share < 0.05 else WRONG,
                   f'{len(gaps)} gaps, longest {gaps.max():.3f} s, {100.0 * share:.1f} % of the '
                   'time', 'record on the robot\'s own computer or over a cable')


def _counts(steps):
    repeated, backward = int(np.sum(steps == 0.0)), int(np.sum(steps < 0.0))
    return f'{repeated} repeated, {backward} backward stamps of {len(steps) + 1}'


def _order(steps):
    share = np.mean(steps <= 0.0)
    return Finding('order', OK if share == 0.0 else graded(share, 0.0, 0.05), _counts(steps),
                   '' if share == 0.0 else 'such messages are rejected and counted; look for two '
                   'publishers on the topic')
