"""Numbers of the command line, refused in one line where they are out of bounds."""

import argparse
import math


def number(low, high=math.inf, kind=float):
    """
    Return an argparse type: a finite number of `kind` (float, int) from low to high.

    The type raises argparse.ArgumentTypeError for other text, with what is allowed.
    """
    # Digits enough for the greatest seed.
    allowed = f'at least {low:g}' if high == math.inf else f'{low:g} to {high:.10g}'

    def convert(text):
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not low <= value <= high or value == math.inf:
            raise argparse.ArgumentTypeError(f'got {text!r}; allowed: {allowed}')
        return value
    return convert
