"""Where a residual lives, as maps: joints against variables, joints against joints."""

import numpy as np

from ..residual.doubts.not_named import real
from .svg import svg_of

_DARK = 0.55             # share from which on a cell's figure is written in white
_ROW, _NAMES = 0.3, 1.5  # [inch] a row of cells, and all that stands around a map
_PANEL = 0.35            # [inch] title of one map


def _shorter(name):
    """Return a joint's name without what all of them end in on most arms."""
    return name.removesuffix('_joint').replace('_', ' ')


def _draw_map(axes, share, chance, rows, columns):
    """Draw shares (R, C) that exceed chance (R, C) as coloured cells with their percent."""
    marked = real(share, chance)
    axes.imshow(np.where(marked, share, np.nan), cmap='Blues', vmin=0.0, vmax=1.0, aspect='auto')
    for (row, column), value in np.ndenumerate(share):
        if marked[row, column]:
            axes.text(column, row, f'{100.0 * min(value, 1.0):.0f}', ha='center', va='center',
                      color='w' if value > _DARK else 'k', fontsize='medium')
        else:
            axes.text(column, row, '·' if np.isfinite(value) else '?', ha='center', va='center',
                      color='0.5')
    axes.set_xticks(range(len(columns)), [])
    axes.set_yticks(range(len(rows)), rows, parse_math=False)
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which='minor', color='0.8', linewidth=0.8)
    axes.tick_params(which='both', length=0)
    axes.spines[:].set_visible(False)


def _maps_svg(maps, rows, columns):
    """Return maps [(title, share, chance)] drawn below one another, columns named once."""
    def draw(figure):
        panels = figure.subplots(len(maps), 1, squeeze=False)[:, 0]
        for axes, (title, share, chance) in zip(panels, maps):
            _draw_map(axes, share, chance, rows, columns)
            axes.set_title(f'{title}, % of structure', fontsize='medium', loc='left')
        panels[-1].set_xticks(range(len(columns)), columns, rotation=90, parse_math=False)
    return svg_of(_NAMES + len(maps) * (_PANEL + _ROW * len(rows)), draw)


def _sides(before, after):
    return [('before', before)] + ([('after', after)] if after is not before else [])


def variables_svg(joints, before, after):
    """Return the maps of variables (rows) and joints of two Structures, one if they are one."""
    maps = [(title, np.array(list(side.share.values())), np.array(list(side.chance.values())))
            for title, side in _sides(before, after)]
    return _maps_svg(maps, list(before.share), [_shorter(name) for name in joints])


def pairs_svg(joints, before, after):
    """Return the map of joints (rows) and the joints whose motion their residual follows."""
    maps = [(title, side.pairs, side.pairs_chance) for title, side in _sides(before, after)]
    names = [_shorter(name) for name in joints]
    return _maps_svg(maps, names, names)
