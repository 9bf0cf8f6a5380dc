"""The demo's live table: what the estimator believes, and what the controller makes of it."""

import shutil
import sys
import time

import numpy as np

_PLAIN_PERIOD = 1.0  # [s] between two lines where there is no terminal to redraw


def _interval(mean, variance, unit, scale=1.0):
    return f'{scale * mean:8.3f} ± {2.0 * scale * np.sqrt(max(variance, 0.0)):7.3f} {unit}'


def table_lines(observer):
    """Return the table as lines; observer: DemoObserver."""
    load, variance = observer.last('load'), observer.last('variance')
    status = observer.last('status') or ('NO_DATA', {})
    lines = [f'phase        {observer.phase or "starting":<12} status  {status[0]}'
             f' ({status[1].get("method", "")})',
             f'             {status[1].get("reason", "")}']
    if load is not None and variance is not None:
        lines.append(f'mass         {_interval(load[0], variance[0], "kg")}   (± 2 sigma)')
        lines += [f'centre {axis}     {_interval(load[k], variance[k], "mm", 1e3)}'
                  for k, axis in enumerate('xyz', 1)]
    if observer.limits is not None and len(observer.limits) == 2:
        for name, row in zip(('accelerate', 'decelerate'), observer.limits):
            lines.append(f'{name}   {" ".join(f"{a:6.2f}" for a in row)} rad/s^2 at most')
    return lines


def plain_line(observer):
    """Return the same in one line."""
    load, variance = observer.last('load'), observer.last('variance')
    status = (observer.last('status') or ('NO_DATA', {}))[0]
    mass = _interval(load[0], variance[0], 'kg') if load is not None and variance is not None \
        else ''
    return f'{observer.phase or "starting":<10} {status:<19} {mass}'


class LiveTable:
    """Redraws the table in a terminal; writes a line a second elsewhere."""

    def __init__(self, out=None):
        self._out = out or sys.stdout
        self._live = self._out.isatty()
        self._height, self._last, self._phase = 0, -_PLAIN_PERIOD, None

    def show(self, observer):
        """Show what the observer knows now."""
        if self._live:
            self._redraw(table_lines(observer))
        elif time.monotonic() - self._last >= _PLAIN_PERIOD or observer.phase != self._phase:
            self._last, self._phase = time.monotonic(), observer.phase
            print(plain_line(observer), file=self._out, flush=True)

    def _redraw(self, lines):
        width = shutil.get_terminal_size().columns - 1
        # Up to the first line of the last table, then each line anew and its rest cleared.
        up = f'\x1b[{self._height}A' if self._height else ''
        self._height = max(self._height, len(lines))
        lines = lines + [''] * (self._height - len(lines))
        self._out.write(up + ''.join(f'\x1b[2K{line[:width]}\n' for line in lines))
        self._out.flush()
