"""The pages of the suites that measure something else than accuracy on one simulated arm."""

import numpy as np

from .document import Heading, Picture, Table, Text
from .measure import MOMENTS
from .soak import FLAT_MIB, FLAT_TIME

_RETRAINING_MOMENTS = MOMENTS[1:]


def _seconds(value):
    return f'{value:.2f}' if np.isfinite(value) else '-'


def _grams(value):
    return f'{1e3 * value:.0f}' if np.isfinite(value) else '-'


def left_out_told(content, why):
    """Return what to say of methods that took no part; why: a clause."""
    names = ', '.join(f'`{name}`' for name in content.get('left_out', ()))
    return f' Not measured here: {names}; {why}.' if names else ''


def change_blocks(content):
    """Return the blocks of the changes suite."""
    methods = content['methods']
    rows = [[name, *(str(m[key]) for key in ('changes', 'missed', 'wrong', 'too_early', 'extra')),
             _seconds(m['delay_median']), _seconds(m['delay_p95'])] for name, m in methods.items()]
    running = [[name, str(m['false_alarms']), f'{m["hours"]:.1f}', f'{100.0 * m["mismatch"]:.2f}',
                _grams(m['mass_rmse']), f'{100.0 * m["inside"]:.0f}']
               for name, m in methods.items()]
    kinds = [[name, *(f'{_seconds(k["delay_median"])} to {_seconds(k["delay_longest"])} s, '
                      f'{k["missed"]} of {k["changes"]} missed'
                      for k in m['kinds'].values())] for name, m in methods.items()]
    return [
        Heading('Changes of the load', 1),
        Text('A load is picked up, exchanged, dropped or slips (mass x shift 0.1 to 0.3 kg m) '
             'once in a run of 14 s. The delay counts from the first motion of a joint that '
             'carries the load after the change. A change is missed where it was never seen, or '
             'where the estimate at the end is of another load: mass and, from 2 kg on, centre of '
             'mass neither within three standard deviations nor within 2 % of the rated mass '
             'and 3 mm.'),
        Table(['method', 'changes', 'missed', 'of these seen, wrong at the end', 'seen before',
               'counted again', 'delay, median [s]', '95th percentile [s]'], rows),
        Text('To a test that knows the load before and after and is not late by a motion filter, '
             'torques are expected to tell as much as is asked of a change after '
             f'{_seconds(content["known"]["delay_median"])} s by median, after '
             f'{_seconds(content["known"]["delay_p95"])} s at the 95th percentile.'),
        Text('False alarms: changes seen while one load stayed through runs of half an hour, each '
             'cold (15 degC) at its start; the mass is that at the end of these runs.'),
        Table(['method', 'false alarms', 'in hours', 'MODEL_MISMATCH [%]',
               'mass RMSE at the end [g]', 'inside the 95 % interval [%]'], running),
        Table(['median to longest delay, missed', *next(iter(methods.values()))['kinds']], kinds),
        Picture('delays', lambda figure: _draw_delays(figure, methods),
                'share of changes seen over the delay after motion')]


def _draw_delays(figure, methods):
    axes = figure.subplots()
    end = max([1.0, *(1.05 * delay for m in methods.values() for delay in m['delays'])])
    for name, m in methods.items():
        delays = np.sort(m['delays'])
        share = np.arange(len(delays) + 1) / max(m['changes'], 1)
        axes.step([0.0, *delays, end], [*share, share[-1]], where='post', label=name)
    axes.axvline(0.2, color='0.6', linestyle=':')
    axes.set(xlabel='delay after motion [s]', ylabel='share of changes seen', ylim=(0.0, 1.02),
             xlim=(0.0, end))
    figure.legend(loc='outside lower center', ncols=3, fontsize='small')


def soak_blocks(content):
    """Return the blocks of the soak suite."""
    broken_off = (f' It was broken off and gone on with: memory is compared within each of '
                  f'{content["processes"]} processes.' if content['processes'] > 1 else '')
    return [
        Heading('Soak', 1),
        Text(f'{content["hours"]:.1f} h of joint states at 125 Hz ({content["samples"]} messages) '
             f'through the pipeline of `{content["method"]}` in {content["seconds"] / 60.0:.0f} '
             f'min: {content["times_real_time"]:.0f} times real time, '
             f'{content["microseconds_per_message"]:.0f} us of processor time per message '
             f'(99th percentile {content["microseconds_p99"]:.0f}). Memory '
             f'{content["growth_mib"]:+.1f} MiB from the first to the last tenth (flat: below '
             f'{FLAT_MIB:g}); from the first to the last fifth time per message, '
             f'measured by a fixed calculation beside it, '
             f'{content["time_drift_percent"]:+.0f} %, its 99th percentile '
             f'{content["tail_drift_percent"]:+.0f} % (flat: below {100.0 * FLAT_TIME:.0f}). '
             f'Load changes seen: {content["load_changes"]} (none happened). Mass at the end '
             f'{content["mass"]:.3f} kg of {content["true_mass"]:g} kg. Rejected: '
             f'{content["rejected"]}.' + broken_off),
        Picture('soak', lambda figure: _draw_soak(figure, content['rows']),
                'memory and time per message over the hours')]


def _draw_soak(figure, rows):
    hours, memory, mean, tail, _, _ = np.array(rows).T
    top, bottom = figure.subplots(2, sharex=True)
    top.plot(hours, memory)
    top.set(ylabel='RSS [MiB]', ylim=(0.0, 1.2 * np.nanmax(memory)))
    bottom.plot(hours, 1e6 * mean, label='mean')
    bottom.plot(hours, 1e6 * tail, label='99th percentile')
    bottom.set(ylabel='per message [us]', xlabel='replayed [h]',
               ylim=(0.0, 1.3e6 * np.max(tail)))
    bottom.legend(fontsize='small')


def retraining_blocks(content):
    """Return the blocks of the retraining suite."""
    blocks = [
        Heading('The learned artefact beside a better torque model', 1),
        Text('An effect happened to an arm after its identification, and a diagnosis made a '
             'better model. Loads it does not know are estimated with that model and: the '
             'artefact as it was, only its intervals calibrated anew, fine-tuned, trained anew '
             'from scratch on draws around the better model; and without a network.')]
    for case in content['cases']:
        rows = [[choice, _minutes(case['seconds'].get(choice)),
                 *(f'{1e3 * figures["mass"][m]:.1f}' for m in _RETRAINING_MOMENTS),
                 f'{1e3 * figures["com"][MOMENTS[-1]]:.2f}',
                 f'{1e3 * figures["half_width"]["1 s"]:.0f}', f'{100.0 * figures["coverage"]:.1f}']
                for choice, figures in case['choices'].items()]
        blocks += [
            Heading(f'{case["effect"]} on {", ".join(case["joints"])}, plant {case["plant"]}, '
                    f'{case["runs"]} loads'),
            Text(f'The diagnosis found: {case["found"]}.'),
            Table(['artefact', 'training [min]',
                   *(f'mass RMSE, {m} [g]' for m in _RETRAINING_MOMENTS),
                   f'centre of mass, {MOMENTS[-1]} [mm]', 'half-width at 1 s [g]',
                   'inside 95 % intervals [%]'], rows)]
    return blocks


def _minutes(seconds):
    return '-' if seconds is None else f'{seconds / 60.0:.1f}'
