"""Read YAML files a person wrote, and refuse wrong ones with a sentence."""

from pathlib import Path
import re

import numpy as np
import yaml

from ..errors import ConfigurationError

_MERGE = 'tag:yaml.org,2002:merge'


def read_yaml(path):
    """Return the mapping in a YAML file; ConfigurationError when it is not one."""
    path = Path(path)
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(path, f'cannot be read ({error})',
                                 todo='give the path of a readable YAML file') from None
    try:
        content = _loaded(text, path)
    # A date that no calendar has, or a number of no base, is a plain ValueError.
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = ' '.join(str(error).split())
        raise ConfigurationError(path, f'is not YAML ({reason})') from None
    if not isinstance(content, dict):
        raise ConfigurationError(path, 'is not a mapping of names to values',
                                 type(content).__name__)
    return content


def _loaded(text, path):
    """Return what YAML says; refuse a key that is there twice, of which the last would hold."""
    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        # Before it is constructed, which puts merged keys beside a mapping's own.
        _refuse_twice(node, path)
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _refuse_twice(root, path):
    for mapping in _mappings(root):
        lines = {}
        for key, _ in mapping.value:
            if not isinstance(key, yaml.ScalarNode) or key.tag == _MERGE:
                continue
            line = key.start_mark.line + 1
            before = lines.setdefault((key.tag, key.value), (key, line))
            if before[0] is not key:
                raise ConfigurationError(f'{path}: {key.value}', 'is there twice',
                                         f'lines {before[1]} and {line}', 'once', 'remove one')


def _mappings(root):
    """Yield the mappings below a YAML node, each once: what is named may be used again."""
    todo, seen = [root], set()
    while todo:
        node = todo.pop()
        if node in seen or isinstance(node, yaml.ScalarNode):
            continue
        seen.add(node)
        if isinstance(node, yaml.MappingNode):
            yield node
            todo += [value for _, value in node.value]
        else:
            todo += node.value


def _float_of(value):
    """
    Return a value as float, NaN for what is no number or larger than any float.

    A number may be written as 1e-3, which YAML 1.1 takes for text without a dot.
    """
    if isinstance(value, str) and re.fullmatch(r'[-+]?\d+[eE][-+]?\d+', value):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return np.nan
    try:
        return float(value)
    except OverflowError:
        return np.nan


class Section:
    """One mapping of a configuration file; every read checks and names its place."""

    def __init__(self, content, where):
        if not isinstance(content, dict):
            raise ConfigurationError(where, 'must be a mapping', content)
        self._content, self._where, self._read = content, str(where), set()

    @property
    def where(self):
        """The place of this mapping, for messages."""
        return self._where

    def has(self, key):
        """Tell whether the key is there and not null."""
        self._read.add(key)
        return self._content.get(key) is not None

    def get(self, key, allowed):
        """Return the raw value; ConfigurationError when it is missing."""
        self._read.add(key)
        if not self.has(key):
            raise ConfigurationError(f'{self._where}: {key}', 'is missing', allowed=allowed,
                                     todo='add it')
        return self._content[key]

    def fail(self, key, what, value, allowed):
        """Raise for the value of a key."""
        raise ConfigurationError(f'{self._where}: {key}', what, value, allowed)

    def text(self, key, choices=None):
        """Return a string, one of `choices` where given."""
        allowed = f'one of {", ".join(choices)}' if choices else 'text'
        value = self.get(key, allowed)
        if not isinstance(value, str) or (choices and value not in choices):
            self.fail(key, 'is not usable', value, allowed)
        return value

    def number(self, key, low=-np.inf, high=np.inf):
        """Return a finite number within [low, high]."""
        allowed = f'a number in [{low:g}, {high:g}]'
        value = self.get(key, allowed)
        number = _float_of(value)
        if not low <= number <= high or not np.isfinite(number):
            self.fail(key, 'is not usable', value, allowed)
        return number

    def flag(self, key):
        """Return a bool."""
        value = self.get(key, 'true or false')
        if not isinstance(value, bool):
            self.fail(key, 'is not usable', value, 'true or false')
        return value

    def names(self, key):
        """Return a non-empty tuple of different strings."""
        allowed = 'a list of different names'
        value = self.get(key, allowed)
        if not isinstance(value, list) or not value \
                or not all(isinstance(v, str) and v for v in value) \
                or len(set(value)) != len(value):
            self.fail(key, 'is not usable', value, allowed)
        return tuple(value)

    def vector(self, key, size, low=-np.inf, high=np.inf):
        """Return a read-only (size,) array of finite numbers within [low, high]."""
        allowed = f'a list of {size} numbers in [{low:g}, {high:g}]'
        value = self.get(key, allowed)
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError, OverflowError):
            array = np.array([])
        if array.shape != (size,) or not np.all(np.isfinite(array)) \
                or np.any(array < low) or np.any(array > high):
            self.fail(key, 'is not usable', value, allowed)
        array.setflags(write=False)
        return array

    def section(self, key):
        """Return a nested mapping."""
        return Section(self.get(key, 'a mapping'), f'{self._where}: {key}')

    def refuse_unknown(self):
        """Raise when a key was never asked for: it is a typing error or not supported."""
        unknown = sorted(set(self._content) - self._read)
        if unknown:
            raise ConfigurationError(self._where, f'does not know {", ".join(map(str, unknown))}',
                                     allowed=', '.join(sorted(self._read)),
                                     todo='remove or rename it')
