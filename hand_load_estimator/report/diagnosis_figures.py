"""The figures of a diagnosis as SVG text: an effect against its variable, errors per joint."""

import numpy as np

from .svg import svg_of

_BEFORE, _AFTER = '0.62', '#1f5fa8'


def _limits(picture):
    """Return y limits [Nm] that show bins and curve; a bin with few samples may leave them."""
    spread = 2.0 * np.nan_to_num(np.nanmedian(picture.std) if np.isfinite(picture.std).any()
                                 else 0.0)
    drawn = np.concatenate([picture.mean - spread, picture.mean + spread, picture.curve, [0.0]])
    drawn = drawn[np.isfinite(drawn)]
    margin = 0.08 * max(np.ptp(drawn), 1e-6)
    return drawn.min() - margin, drawn.max() + margin


def _draw_effect(figure, picture):
    axes = figure.subplots()
    axes.axhline(0.0, color='0.6', linewidth=0.8)
    if picture.fitted:
        _draw_fit(axes, picture)
    else:
        _draw_left(axes, picture)
    axes.set_ylim(*_limits(picture))
    axes.set_title(picture.joint, parse_math=False, fontsize='medium')
    axes.set_xlabel(picture.variable, parse_math=False)
    axes.set_ylabel('residual torque [Nm]')
    axes.locator_params(axis='x', nbins=6)
    figure.legend(loc='outside lower center', frameon=False, fontsize='small')


def _draw_left(axes, picture):
    if np.any(picture.std):
        axes.errorbar(picture.x, picture.mean, 2.0 * np.asarray(picture.std), fmt='o',
                      color='0.15', markersize=3.0, elinewidth=0.9,
                      label='what is left, ±2 standard errors; nothing was fitted')
    else:
        axes.plot(picture.x, picture.mean, '.', color='0.15', markersize=3.0,
                  label='what is left; nothing was fitted')


def _draw_fit(axes, picture):
    axes.fill_between(picture.x, picture.low, picture.high, color=_AFTER, alpha=0.25,
                      linewidth=0.0)
    axes.plot(picture.x, picture.curve, color=_AFTER, linewidth=2.0,
              label='fitted effect with 95 % band')
    axes.errorbar(picture.x, picture.mean, 2.0 * np.asarray(picture.std), fmt='o', color='0.15',
                  markersize=3.0, elinewidth=0.9, label='measured, ±2 standard errors')


def effect_svg(picture):
    """Return a Picture drawn: bins with error bars, fitted curve and its 95 % band."""
    return svg_of(3.6, lambda figure: _draw_effect(figure, picture))


def _draw_bars(axes, y, values, color, label):
    """Draw and return one bar per joint with its value written behind it."""
    known = np.nan_to_num(values)
    bars = axes.barh(y, known, height=0.28, color=color, label=label)
    axes.bar_label(bars, [f'{value:#.3g}'.rstrip('.') if np.isfinite(value) else 'not known'
                          for value in values], padding=4, fontsize='small')
    return bars


def _draw_errors(figure, diagnosis):
    axes = figure.subplots()
    y = np.arange(len(diagnosis.joints), dtype=float)
    before = _draw_bars(axes, y, diagnosis.before, _BEFORE, 'before')
    after = _draw_bars(axes, y + 0.3, diagnosis.after, _AFTER, 'after')
    limits = [diagnosis.noise_floor]
    if diagnosis.noise_most is not None:
        limits.append(diagnosis.noise_most)
    for noise in limits:
        floor = axes.vlines(noise, y - 0.17, y + 0.47, color='k', linewidth=1.6,
                            linestyle=(0, (2.0, 1.0)), label='noise')
    # Names stand above their bars: beside them long names would leave no room for the bars.
    for place, name in zip(y, diagnosis.joints):
        axes.annotate(name, (0.0, place - 0.2), (3.0, 0.0), textcoords='offset points',
                      va='bottom', parse_math=False)
    axes.set_ylim(len(y) - 0.4, -0.6)
    axes.set_yticks([])
    axes.margins(x=0.12)
    axes.set_xlabel('torque error, RMSE [Nm]')
    figure.legend(handles=[before, after, floor], loc='outside upper center', ncols=3,
                  frameon=False, handlelength=1.2, columnspacing=1.2)


def errors_svg(diagnosis):
    """Return the torque error of every joint drawn: before, after, noise."""
    return svg_of(1.0 + 0.68 * len(diagnosis.joints),
                  lambda figure: _draw_errors(figure, diagnosis))
