"""Files that appear whole or not at all, whenever a process is killed."""

from contextlib import contextmanager
import os
from pathlib import Path


@contextmanager
def whole_file(path):
    """
    Yield a Path to write to; it takes the place of `path` when the block ends without an error.

    Its own per process, as another one may write the same file; with the mode that any new file
    of the process has, whatever the writer gave it. A pipe or a device is written to itself.
    Raises OSError.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        yield path
        return
    part = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        yield part
        part.chmod(0o666 & ~_umask())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def _umask():
    """Return the process's umask, which can only be read by setting it."""
    umask = os.umask(0o077)
    os.umask(umask)
    return umask
