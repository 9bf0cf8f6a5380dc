"""The demo's picture: estimate against truth, temperatures, residual torque over time."""

import numpy as np

_AXES = 'xyz'
# A centre of mass is drawn only while it is known at all, of a mass that is surely there.
_HIGHEST_COM_STD = 0.15  # [m]
_LEAST_MASS = 0.1  # [kg]


def _stack(series):
    times = np.array([t for t, _ in series])
    return times, np.array([value for _, value in series])


def _joined(load, variance):
    """Return times (k,), mean (k, 10), std (k, 10) of stamps both series have."""
    variances = dict(variance)
    both = [(t, mean, variances[t]) for t, mean in load if t in variances]
    times, means, variances = (np.array(column) for column in zip(*both))
    return times, means, np.sqrt(np.maximum(variances, 0.0))


def _step(series, end):
    """Return times and values of a series that holds its value until the next one."""
    times, values = _stack(series)
    times = np.append(times, max(end, times[-1]))
    return times, np.vstack([values, values[-1:]])


def _band(axis, times, mean, std, label, color):
    axis.plot(times, mean, color=color, label=label)
    axis.fill_between(times, mean - 2.0 * std, mean + 2.0 * std, color=color, alpha=0.25,
                      linewidth=0.0)


def _mass(axis, times, mean, std, truth):
    _band(axis, times, mean[:, 0], std[:, 0], 'estimate, 2 sigma', 'C0')
    axis.step(truth[0], truth[1][:, 0], 'k--', where='post', label='truth')
    highest = max(1.0, 1.5 * truth[1][:, 0].max())
    axis.set_ylim(-0.15 * highest, highest)
    axis.set_ylabel('mass [kg]')
    axis.legend(loc='upper right', ncols=2)


def _centre(axis, times, mean, std, truth):
    held = truth[1][:, 0] > 0.0
    heavy = mean[:, 0] > np.maximum(_LEAST_MASS, 3.0 * std[:, 0])
    for k, name in enumerate(_AXES, 1):
        known = heavy & (std[:, k] < _HIGHEST_COM_STD)
        _band(axis, times, np.where(known, 1e3 * mean[:, k], np.nan), 1e3 * std[:, k], name,
              f'C{k}')
        axis.step(truth[0], np.where(held, 1e3 * truth[1][:, k], np.nan), f'C{k}--',
                  where='post')
    known = 1e3 * truth[1][held, 1:4] if held.any() else np.zeros((1, 3))
    axis.set_ylim(known.min() - 80.0, known.max() + 80.0)
    axis.set_ylabel('centre of mass [mm]\n(dashed: truth)')
    axis.legend(loc='upper right', ncols=3)


def _temperatures(axis, series, joints):
    for joint in joints:
        rows = [(t, celsius) for t, (name, celsius) in series if name == joint]
        if rows:
            axis.plot(*_stack(rows), label=joint)
    axis.set_ylabel('temperature [°C]')
    axis.legend(loc='upper right', ncols=3, fontsize='x-small')


def _residual(axis, series, joints):
    times, torque = _stack(series)
    for j, joint in enumerate(joints):
        axis.plot(times, torque[:, j], linewidth=0.8, label=joint)
    axis.set_ylabel('residual torque [Nm]\nmeasured - model')
    axis.set_xlabel('time [s]')


def _phases(axes, series, begin, end):
    for k, (start, name) in enumerate(series):
        start, stop = max(start, begin), series[k + 1][0] if k + 1 < len(series) else end
        for axis in axes:
            axis.axvspan(start, stop, color='0.5', alpha=0.10 * (k % 2), linewidth=0.0)
        if stop - start > 0.03 * (end - begin):
            axes[0].text(0.5 * (start + stop), 1.02, name, ha='center', fontsize='small',
                         transform=axes[0].get_xaxis_transform())


def draw_demo(path, series, joints, title):
    """
    Write the picture to `path` (PNG).

    series: as DemoObserver collects them; joints: names of the residual's entries. Raises
    ValueError when nothing was estimated.
    """
    # Here, so that commands that draw nothing do not wait for it.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    if not series['load'] or not series['truth']:
        raise ValueError('there is no estimate or no truth to draw')
    times, mean, std = _joined(series['load'], series['variance'])
    truth = _step(series['truth'], times[-1])
    figure = Figure(figsize=(11.0, 12.0), layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(4, 1, sharex=True)
    _mass(axes[0], times, mean, std, truth)
    _centre(axes[1], times, mean, std, truth)
    _temperatures(axes[2], series['temperature'], joints)
    if series['residual']:
        _residual(axes[3], series['residual'], joints)
    _phases(axes, series['phase'], times[0], times[-1])
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.set_xlim(times[0], times[-1])
    figure.suptitle(title)
    figure.savefig(path, dpi=110)
