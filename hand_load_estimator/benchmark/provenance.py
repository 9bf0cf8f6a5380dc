"""Which code results are of, and the note beside them that refuses to mix two runs."""

import hashlib
import json
from pathlib import Path
import subprocess

from ..errors import ConfigurationError
from ..files.whole_file import whole_file

PACKAGE = Path(__file__).resolve().parent.parent


def sources():
    """Return a digest of the package's own Python files, wherever it is installed."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob('*.py')):
        content = path.read_bytes()
        digest.update(f'{path.relative_to(PACKAGE).as_posix()} {len(content)}\n'.encode())
        digest.update(content)
    return digest.hexdigest()


def commit_now():
    """Return the code's commit and a digest of what was changed since; without one, sources."""
    unknown = f'unknown, sources {sources()[:8]}'
    try:
        # Installed into a folder of another repository, the code is none of that one's commits.
        commit = _git('ls-files', '__init__.py') and _git('rev-parse', '--short', 'HEAD')
        changes = commit and _git('diff', 'HEAD')
    except OSError:
        return unknown
    digest = hashlib.sha256(changes.encode()).hexdigest()[:8]
    return f'{commit} with changes {digest}' if changes else commit or unknown


def _git(*arguments):
    return subprocess.run(['git', *arguments], text=True, capture_output=True, cwd=PACKAGE,
                          check=False).stdout.strip()


def same_run(raw, key):
    """
    Note in raw/key.json what the raw results belong to; refuse to mix two runs.

    key: what they depend on, `commit` and `sources` among it. Notes from before sources were
    noted are told by their commit alone.
    """
    note = raw / 'key.json'
    if not note.exists():
        with whole_file(note) as part:
            part.write_text(json.dumps(key), encoding='utf-8')
        return
    own = json.loads(note.read_text('utf-8'))
    if {'sources': key['sources'], **own} != key:
        raise ConfigurationError(raw, 'holds results of another suite, robot, artefact or commit',
                                 todo='remove it or give another --out')
