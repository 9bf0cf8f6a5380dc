"""
The checkpoint: what is believed of the load, on disk, for a node that is killed and starts again.

A safetensors file with the arrays of Pipeline.state() and, in its metadata, whose they are, when
they were written and a digest of it all. It appears whole or not at all.
"""

import hashlib
import json
import os
from pathlib import Path
import time

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from ..errors import HandLoadError

SCHEMA = 'hand_load/checkpoint/4'
_KIND = SCHEMA.rstrip('0123456789').encode()
# A file from the future by more than this [s] was written by another clock: its age is unknown.
CLOCK_STEP = 60.0


class CheckpointError(HandLoadError):
    """A checkpoint cannot be gone on from; the sentence says why."""


def was_checkpoint(path):
    """Tell whether a file is or was a checkpoint, of any version or damaged; raises OSError."""
    raw = Path(path).read_bytes()
    return raw[8:9] == b'{' and _KIND in raw


def belongs_to(pipeline, node=''):
    """
    Return what must agree between a checkpoint and a Pipeline, as plain text.

    node: full name of the node that keeps it: arms alike have a load each.
    """
    robot, tool = pipeline.model.robot, pipeline.tool
    return {'node': node, 'robot': robot.name, 'joints': ', '.join(robot.joints),
            'effort kind': robot.effort.kind, 'load frame': robot.load_frame,
            'model': pipeline.digest, 'method': pipeline.method.name,
            'tool': ' '.join(f'{value:.9g}' for value in (*tool.products, *tool.root.ravel()))
            if tool else 'none'}


def _digest(arrays, notes):
    digest = hashlib.sha256(json.dumps(notes, sort_keys=True).encode())
    for name in sorted(arrays):
        digest.update(f'{name} {arrays[name].shape} {arrays[name].dtype}'.encode())
        digest.update(arrays[name].tobytes())
    return digest.hexdigest()


def write_checkpoint(path, state, owner, now=None):
    """
    Write a state ({name: array}) of the owner (belongs_to) at `now` [s since 1970], atomically.

    Safe against a kill or a power cut at any moment: the old file stays until the new one is on
    disk. Raises OSError.
    """
    path = Path(path)
    arrays = {name: np.array(value, dtype=float, order='C') for name, value in state.items()}
    notes = {'schema': SCHEMA, 'written': repr(float(time.time() if now is None else now)),
             **{f'owner {key}': value for key, value in owner.items()}}
    content = save(arrays, {**notes, 'digest': _digest(arrays, notes)})
    part = path.with_name(path.name + '.part')
    with open(part, 'wb') as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)
    _sync_folder(path.parent)


def _sync_folder(folder):
    """Bring the new name to disk too."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def read_checkpoint(path, owner, max_age, now=None):
    """
    Return (state, age [s]) of a file; CheckpointError when it is not the owner's, or too old.

    max_age [s]; now [s since 1970].
    """
    arrays, notes = _content(Path(path))
    for key, value in owner.items():
        if notes.get(f'owner {key}') != value:
            told = '' if key == 'model' else f': {notes.get(f"owner {key}")}, not {value}'
            raise CheckpointError(f'{path} belongs to another {key}{told}')
    age = (time.time() if now is None else now) - float(notes['written'])
    if age < -CLOCK_STEP:
        raise CheckpointError(f'{path} was written {-age:.0f} s in the future by this clock: its '
                              'age is not known')
    if age > max_age:
        raise CheckpointError(f'{path} is {age:.0f} s old, more than the {max_age:.0f} s allowed')
    return arrays, max(age, 0.0)


def written_by(path):
    """Return the full name of the node that a checkpoint is of, or None where nobody can tell."""
    try:
        return _content(Path(path))[1].get('owner node')
    except CheckpointError:
        return None


def _content(path):
    """Return ({name: array}, notes) of a file that is whole."""
    try:
        raw = path.read_bytes()
        arrays = load(raw)
        # The header: eight bytes of its length, then JSON.
        header = json.loads(raw[8:8 + int.from_bytes(raw[:8], 'little')])
        notes = header['__metadata__']
        digest = notes.pop('digest')
    except (OSError, SafetensorError, ValueError, KeyError, TypeError) as error:
        raise CheckpointError(f'{path} is damaged or no checkpoint '
                              f'({" ".join(str(error).split())})') from None
    if digest != _digest(arrays, notes):
        raise CheckpointError(f'{path} is damaged: its digest does not agree')
    if notes.get('schema') != SCHEMA:
        raise CheckpointError(f'{path} is of another version: {notes.get("schema")}')
    return arrays, notes


def restore_checkpoint(path, pipeline, max_age, node=''):
    """
    Go on from a file; return in words what was restored; CheckpointError when refused.

    node: as of belongs_to.
    """
    state, age = read_checkpoint(path, belongs_to(pipeline, node), max_age)
    told = f'as it was {_span(age)} before the start'
    try:
        pipeline.restore(state, told)
    except ValueError as error:
        raise CheckpointError(f'{path} does not fit: {error}') from None
    return told


def _span(seconds):
    return f'{seconds:.0f} s' if seconds < 600.0 else f'{seconds / 60.0:.0f} min'
