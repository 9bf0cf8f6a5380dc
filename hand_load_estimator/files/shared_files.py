"""Find the files shipped with the package: config, learned artefacts."""

from pathlib import Path

from ..errors import ConfigurationError

PACKAGE = 'hand_load_estimator'


def share_folder():
    """
    Return the folder that holds config/: the source tree, a pip or a colcon installation.

    colcon and pip both put it at share/hand_load_estimator below the prefix the code lives in.
    """
    here = Path(__file__).resolve().parent.parent
    if (here.parent / 'package.xml').is_file():
        return here.parent
    for prefix in here.parents:
        if (prefix / 'share' / PACKAGE / 'config').is_dir():
            return prefix / 'share' / PACKAGE
    raise ConfigurationError(here, f'share/{PACKAGE} was not found beside the installed code',
                             todo='install with `pip install .` or `colcon build`')


def at_home(name):
    """Return the path of a name, of which `~` is a home, but of a user whom nobody knows."""
    try:
        return Path(name).expanduser()
    except RuntimeError:
        return Path(name)


def find_shared(name, *folders):
    """
    Return the path `name` stands for: a path that exists, or a shipped file's short name.

    folders: where under config/ short names are looked for, e.g. 'robots'. A folder in the way
    does not hide a shipped file of the same short name: no folder is what is asked for then.
    """
    direct = at_home(name)
    if direct.exists() and not direct.is_dir():
        return direct
    config = share_folder() / 'config'
    shipped = next((candidate for folder in (config, *(config / f for f in folders))
                    for candidate in (folder / name, folder / f'{name}.yaml')
                    if candidate.exists()), None)
    hidden = shipped is not None and shipped.is_file() and str(name) == direct.name
    if direct.is_dir() and not hidden:
        return direct
    if shipped is not None:
        return shipped
    known = sorted(p.stem for f in folders for p in (config / f).glob('*')
                     if p.suffix == '.yaml' or p.is_dir())
    raise ConfigurationError(name, 'is neither a path nor a shipped file',
                             allowed=f'a path or one of {", ".join(known)}' if known
                             else 'a path')
