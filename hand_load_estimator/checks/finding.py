"""One answer of `hand_load check`."""

from dataclasses import dataclass

OK, DOUBT, WRONG, UNKNOWN = 'ok', 'doubt', 'wrong', 'cannot tell'


@dataclass(frozen=True)
class Finding:
    """item: what was looked at; verdict; text: what was found; todo: what to do about it."""

    item: str
    verdict: str
    text: str
    todo: str = ''


def graded(value, ok_below, doubt_below):
    """Return the verdict of a magnitude: ok, doubt or wrong."""
    return OK if value <= ok_below else DOUBT if value <= doubt_below else WRONG
