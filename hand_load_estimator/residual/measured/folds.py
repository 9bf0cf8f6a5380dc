"""
Cut recordings into blocks, and say which of them are held out together.

A gain on data not fitted means something only where nothing like it was fitted. Motion that
recordings repeat is therefore one piece, wherever it is shown: a block of it, held out, takes its
twins with it, and all of them together are one observation.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..diagnosis import SUSPECTED
from .repeats import share_shown

# Blocks [s] outlast what colours the residual, and recordings give a good number of them.
BLOCK, FEWEST_BLOCKS = 4.0, 12
# Recordings from which on they are folds themselves; fewer are cut in so many spans of time.
SEVERAL, SPANS = 3, 6
# A fold of repeated motion holds at least so much of it [s], and so many folds can confirm.
SPAN, FEWEST_FOLDS = 2.0, 3
# Share of a test's motion from which on it is the motion of what is fitted.
MOSTLY = 0.5


@dataclass(frozen=True)
class Cut:
    """
    How rows are cut into B blocks.

    starts (B,): first rows; folds (B,): what is held out together; groups (B,): from 0, blocks
    that are one observation because they repeat one motion; shown [s]: time in motion without its
    repetitions where it is too short to hold any of it out, else None.
    """

    starts: np.ndarray
    folds: np.ndarray
    groups: np.ndarray
    shown: float | None = None


UNCUT = Cut(np.zeros(1, int), np.zeros(1, int), np.zeros(1, int))


def cut_into_blocks(dt, owner, recording, shown):
    """
    Return the Cut of rows: recordings are folds, or spans of time where there are few.

    dt (N,) [s]; owner (N,): part of a recording, recording (N,) its number; shown: Shown.
    """
    if shown.fresh.all():
        return _in_time(dt, owner, recording)
    new = dt * (shown.fresh & shown.moving)
    if new.sum() < FEWEST_FOLDS * SPAN:
        return replace(_in_time(dt, owner, recording), shown=float(new.sum()))
    return _by_motion(new, owner, recording, shown.first)


def _in_time(dt, owner, recording):
    """Return the Cut of recordings without any repetition."""
    total = float(dt.sum())
    length = min(BLOCK, total / FEWEST_BLOCKS)
    starts, recordings = [], []
    for k in np.unique(owner):
        rows = np.flatnonzero(owner == k)
        blocks = max(1, round(float(dt[rows].sum()) / length))
        first = rows[0] + (np.arange(blocks) * len(rows)) // blocks
        starts.extend(first)
        recordings.extend([recording[rows[0]]] * blocks)
    starts, each = np.array(starts), np.arange(len(starts))
    # Leaving recordings out tests other temperatures too; few recordings are cut in time.
    several = len(np.unique(recording)) >= SEVERAL
    return Cut(starts, np.array(recordings) if several else each * SPANS // len(starts), each)


def _by_motion(new, owner, recording, first):
    """Return the Cut by where in the motion rows are; new (N,) [s]: time of motion not shown."""
    source, total = recording[first], float(new.sum())
    place = np.cumsum(new)[first] // min(BLOCK, total / FEWEST_BLOCKS)
    pieces, group = np.unique(np.stack([source, place]), axis=1, return_inverse=True)
    group = group.ravel()
    starts = np.flatnonzero((np.diff(group, prepend=-1) != 0) | (np.diff(owner, prepend=-1) != 0))
    # What repeats another recording is no fold of its own.
    several = (np.bincount(recording, weights=new) >= SPAN).sum() >= SEVERAL
    spans = np.arange(pieces.shape[1]) * min(SPANS, int(total / SPAN)) // pieces.shape[1]
    folds = pieces[0].astype(int) if several else spans
    return Cut(starts, folds[group[starts]], group[starts])


def repeated(cut, evidence, test):
    """Return sentences on what the repetition of motion keeps untold; evidence: what is fitted."""
    told = []
    if cut.shown is not None:
        told.append('cannot tell any effect for sure because all recordings repeat one motion of '
                    f'{cut.shown:.1f} s: whatever is held out has its twin in what is fitted; '
                    'record other motions too')
    if share_shown(evidence, test) > MOSTLY:
        told.append('cannot tell how large the errors are in other motions because what is kept '
                    'for the test repeats the motion of the rest; give --test another motion')
    return told


def only_suspected(findings):
    """Return Findings of which none is confirmed by folds."""
    return tuple(f if f.recording else replace(f, verdict=SUSPECTED) for f in findings)
