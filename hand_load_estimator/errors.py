"""Errors a user can do something about."""


class HandLoadError(Exception):
    """Base of every error this package raises on purpose."""


class ConfigurationError(HandLoadError):
    """
    A file, parameter or command line is wrong.

    The message says what, where, the value, what is allowed and what to do.
    """

    def __init__(self, where, what, value=None, allowed=None, todo=None):
        parts = [f'{where}: {what}']
        if value is not None:
            parts.append(f'got {value!r}')
        if allowed is not None:
            parts.append(f'allowed: {allowed}')
        if todo is not None:
            parts.append(todo)
        super().__init__('; '.join(parts))
        self.where = str(where)
        self._said = where, what, value, allowed, todo

    def __reduce__(self):
        # A worker process hands it to its parent pickled.
        return type(self), self._said


class RecordingError(HandLoadError):
    """A recording cannot be read or does not fit the robot."""
