"""Files that appear whole or not at all, whenever a process is killed."""

from contextlib import contextmanager
import os
from pathlib import Path


@contextmanager
def whole_file(path):
    """
    Yield a Path to write to; it takes the place of `path` when the block ends without an error.

    Its own per process, as another one may write the same file. Raises OSError.
    """
    path = Path(path)
    part = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        yield part
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
