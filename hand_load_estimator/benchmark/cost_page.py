"""The page of the cost suite: what a sample and a joint state cost over one regressor call."""

from .contestants import REGRESSOR
from .cost import RATES, SAMPLES, seconds_per_joint_state
from .document import Heading, Table, Text
from .measure import RATE
from .other_pages import left_out_told


def cost_blocks(content):
    """Return the blocks of the cost suite."""
    names = list(content['cost'])
    other = [f'`{name}` has no artefact here and ran as `{found}`.'
             for name, found in content['is'].items() if name != found]
    return [
        Heading('Cost of one sample', 1),
        Text('Processor time of each method, alone in its process, its torque model included; '
             f'a sample comes every 20 ms however fast joint states do. The unit, {REGRESSOR}, '
             'gives the columns of all links; the load\'s are the last ten. *Undisturbed* it is '
             'called in a loop of its own over the same samples, before the method is built; '
             '*beside*, between the samples of the method: what that leaves in the caches makes '
             'the call slower. The goal is judged by the undisturbed one.'
             + ''.join(f' {sentence}' for sentence in other)
             + left_out_told(content, 'nothing learned of theirs is shipped')),
        Table(['per 20 ms sample', 'mean [us]', 'p50 [us]', 'p99 [us]',
               'regressor call undisturbed [us]', 'beside [us]', 'mean / undisturbed',
               'p99 / undisturbed', 'mean / beside', 'p99 / beside'],
              [_sample_row(name, content) for name in names]),
        Text('Guard and filter are paid for every joint state; with its share of a sample (of '
             f'{SAMPLES:g} a second) that is what a joint state costs on average. Measured at '
             f'{RATE:g} Hz, and taken for the same at other rates. The share of one core is '
             'without ROS.'),
        Table(['per joint state', 'guard and filter [us]',
               *(f'{what}, {rate:g} Hz{unit}' for rate in RATES for what, unit in (
                   ('with its share of a sample', ' [us]'), ('the same / undisturbed', ''),
                   ('share of a core', ' [%]'))),
               'memory to build [MiB]', 'growth in 13 s [MiB]'],
              [_joint_state_row(name, content) for name in names])]


def _sample_row(name, content):
    cost, alone, beside = (content[what][name]
                           for what in ('cost', 'regressor_alone', 'regressor'))
    return [name, *(f'{1e6 * cost[key]:.1f}' for key in ('mean', 'p50', 'p99')),
            *(f'{1e6 * unit["mean"]:.1f}' for unit in (alone, beside)),
            *(f'{cost[key] / unit["mean"]:.0f}' for unit in (alone, beside)
              for key in ('mean', 'p99'))]


def _joint_state_row(name, content):
    unit, memory = content['regressor_alone'][name]['mean'], content['memory'][name]
    row = [name, f'{1e6 * content["joint_state"][name]["mean"]:.1f}']
    for rate in RATES:
        each = seconds_per_joint_state(content, name, rate)
        row += [f'{1e6 * each:.1f}', f'{each / unit:.0f}', f'{100.0 * rate * each:.1f}']
    return [*row, *(f'{memory[key]:+.1f}' for key in ('start_mib', 'growth_mib'))]
