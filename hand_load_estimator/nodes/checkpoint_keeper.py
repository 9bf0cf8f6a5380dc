"""Keep a node's checkpoint: restore at the start, write in a thread, tell how it stands."""

import queue
import threading
import time

from ..errors import ConfigurationError
from ..estimators.checkpoint import (CheckpointError, belongs_to, restore_checkpoint,
                                     was_checkpoint, write_checkpoint, written_by)
from ..files.shared_files import at_home
from .diagnostics import OK, WARN

_LAST_WRITE = 5.0  # [s] a full disk may hold up the end of a node


class CheckpointKeeper:
    """
    Restore a Pipeline from a file and write its state there again and again.

    path: the file, in a folder that exists, or an empty text for none; max_age [s]: older files
    are refused, and those of another node (full name), which stay. Another refused file is put
    aside under the name `<file>.refused`; ConfigurationError where it never was a checkpoint.
    told: in words what came of restoring.
    """

    def __init__(self, path, max_age, node=''):
        self._path = _checked(path) if path else None
        self._max_age, self._node = max_age, node
        self._seen, self._written, self._failure, self.refused = None, None, '', False
        self.told = 'none' if self._path is None else 'no file yet'
        # One state waits at most: where the disk is slower than the node, the newest counts.
        self._waiting = queue.Queue(maxsize=1)
        self._writer = threading.Thread(target=self._write_all, daemon=True)

    def restore(self, pipeline):
        """Go on from the file where there is one that fits; else the Pipeline starts afresh."""
        if self._path is None or not self._path.exists():
            return
        try:
            told = restore_checkpoint(self._path, pipeline, self._max_age, self._node)
            self.told = f'restored {told}'
        except CheckpointError as error:
            self.refused = True
            # What another node keeps is not put aside: it is in use.
            aside = self._put_aside() if self._is_own() else ''
            self.told = f'refused: {error}; the estimate starts afresh{aside}'

    def _is_own(self):
        """Tell whether the file is nobody else's, as far as anybody can tell."""
        return written_by(self._path) in (None, self._node)

    def _put_aside(self):
        """Return in words where the refused file is now."""
        aside = f'{self._path}.refused'
        try:
            self._path.replace(aside)
        except OSError as error:
            self._failure = _sentence(error)
            return ''
        return f', and the file is {aside} now'

    def keep(self, pipeline, even_if_old=False):
        """
        Hand the Pipeline's state to the writer when there are data the file does not have.

        What was restored and has seen no motion yet is as old as the file says.
        """
        if self._path is None or not even_if_old and (
                pipeline.estimates == self._seen or pipeline.unconfirmed):
            return
        self._seen = pipeline.estimates
        self._hand_over((pipeline.state(), belongs_to(pipeline, self._node)))

    def _hand_over(self, item):
        if self._writer.ident is None:
            self._writer.start()
        try:
            self._waiting.get_nowait()
        except queue.Empty:
            pass
        self._waiting.put(item)

    def stop(self, pipeline):
        """Write the last state and end the writer."""
        if self._path is None:
            return
        self.keep(pipeline)
        if self._writer.ident is None:
            return
        end = time.monotonic() + _LAST_WRITE
        try:
            self._waiting.put(None, timeout=_LAST_WRITE)
        except queue.Full:
            return
        self._writer.join(max(end - time.monotonic(), 0.0))

    def _write_all(self):
        while True:
            item = self._waiting.get()
            if item is None:
                return
            if not self._is_own():
                self._failure = (f'{written_by(self._path)} keeps its own there; give each node a '
                                 'file of its own')
                continue
            try:
                write_checkpoint(self._path, *item)
                self._written, self._failure = time.time(), ''
            except OSError as error:
                self._failure = _sentence(error)

    def report(self):
        """Return (level, message, values) for /diagnostics."""
        values = {'file': self._path or 'none'}
        if self._written is not None:
            values['written before [s]'] = time.time() - self._written
        if self._failure:
            return WARN, f'cannot be written: {self._failure}', values
        return WARN if self.refused else OK, self.told, values


def _checked(path):
    path = at_home(path)
    if path.is_dir() or not path.absolute().parent.is_dir():
        raise ConfigurationError('node estimator: parameter checkpoint', 'is not usable',
                                 str(path), 'the path of a file in a folder that exists')
    if path.exists() and not _may_go(path):
        raise ConfigurationError('node estimator: parameter checkpoint', 'is no checkpoint and '
                                 'would be lost', str(path), 'a new file or a checkpoint',
                                 'give another path')
    return path


def _may_go(path):
    """Tell whether a file is a checkpoint or holds nothing."""
    try:
        return not path.stat().st_size or was_checkpoint(path)
    except OSError as error:
        raise ConfigurationError('node estimator: parameter checkpoint',
                                 f'cannot be read ({_sentence(error)})', str(path)) from None


def _sentence(error):
    return ' '.join(str(error).split())
