"""Which recording was it? Its content tells: folders of two days have the same names."""

from dataclasses import dataclass
import hashlib

import numpy as np

from ..errors import RecordingError

# A message that a driver tells twice, once in each of two recordings, makes them no copies.
SHARED = 0.01


@dataclass(frozen=True)
class RecordingMark:
    """Name of a recording's folder; content: digest of its joint states, '' where not known."""

    name: str
    content: str = ''


def message_digests(recording):
    """Return a digest (M,) uint64 of each joint state of a Recording, in recorded order."""
    return np.array([_digest(sample) for sample in recording.joint_samples], dtype=np.uint64)


def _digest(sample):
    values = np.concatenate([[sample.stamp], sample.position, sample.velocity, sample.effort])
    digest = hashlib.blake2b(values.astype('<f8').tobytes(), digest_size=8).digest()
    return int.from_bytes(digest, 'little')


def content_of(digests):
    """Return the digest of a recording's content from those of its messages, '' for none."""
    text = hashlib.sha256(digests.astype('<u8').tobytes()).hexdigest()[:16]
    return text if len(digests) else ''


def refuse_repeats(evidence, test=()):
    """
    Raise RecordingError where two recordings, Evidence each, hold the same joint states.

    test: those to test on. What holds no digests of its messages is passed over.
    """
    for k, one in enumerate(evidence):
        for other in evidence[:k]:
            _refuse_shared(other, one, 'give every recording only once')
        for other in test:
            _refuse_shared(one, other, 'test on a recording that is not among those to learn from')
    for k, one in enumerate(test):
        for other in test[:k]:
            _refuse_shared(other, one, 'give every recording to test on only once')


def _refuse_shared(one, other, todo):
    fewer = min(len(one.messages), len(other.messages))
    shared = len(np.intersect1d(one.messages, other.messages))
    if shared > SHARED * fewer:
        raise RecordingError(f'{one.name} and {other.name}: hold the same joint states '
                             f'({shared} of {fewer}); {todo}')
