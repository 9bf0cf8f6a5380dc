"""The report.json files of all sets as one Markdown table."""

HEAD = ('| set | joint | torque RMSE [Nm] | noise [Nm] | effects named | named with the parts '
        'exchanged | left, and what the recordings cannot tell |', '|---|---|---|---|---|---|---|')
LOADED_HEAD = ('| set | loaded run | known mass [kg] | estimated before -> after [kg] | '
               'error [g] |', '|---|---|---|---|---|')
# Structure below this share of what is left is told as noise, as in the report.
_WEIGHTY = 0.05


def _number(value):
    return '-' if value is None else f'{value:.3g}'


def _range(low, high, form):
    """Return two figures as one where they read the same; the larger is not known without both."""
    if low is None or high is None:
        return '-'
    low, high = form(low), form(high)
    return high if low == high else f'{low} to {high}'


def _cell(text):
    """Return text that cannot break a table's row."""
    return ' '.join(str(text).split()).replace('|', '/')


def _named(effect, joint):
    """Return an effect and what at this joint is nearly as likely."""
    names = dict.fromkeys(other['effect'] for other in effect['alternatives_detail']
                          if joint in other['joints'])
    others = ''.join(f' or `{name}`' for name in names)
    return f'`{effect["name"]}`{others} ({effect["verdict"]})'


def _all_named(report, joint):
    return ', '.join(_named(effect, joint) for effect in report['effects']
                     if joint in effect['joints']) or 'none'


def rows_of(name, report, again):
    """
    Return a set's table rows.

    report: content of its report.json (DESIGN section 4); again: the same with what was learned
    from and tested on exchanged, or the sentence that says why there is none.
    """
    rows = []
    for joint, before, after, *noise_share in zip(
            report['joints'], report['before']['torque_rmse'], report['after']['torque_rmse'],
            report['noise_floor'], report['noise_most'], report['unexplained'],
            report['unexplained_most']):
        noise, share = noise_share[:2], noise_share[2:]
        other = f'failed: {_cell(again)}' if isinstance(again, str) else _all_named(again, joint)
        rows.append(f'| {name} | {joint} | {_number(before)} -> {_number(after)} | '
                    f'{_range(*noise, _number)} | {_all_named(report, joint)} | {other} | '
                    f'{_left(joint, share, report)} |')
    return rows


def _follows(joint, report):
    """Return in words what structure of a joint follows that no effect explains, or nothing."""
    if report['not_named'] is None:
        return []
    found = report['not_named'][report['joints'].index(joint)]
    words = ', '.join(f'{one["follows"]} ({_percent(one["share"])} %)' for one in found)
    return [f'not named: follows {words}'] if words else []


def _left(joint, share, report):
    """Return what is left of a joint, and what the report cannot tell of it."""
    left = [_structure(*share), *_follows(joint, report)]
    others = [name for name in report['joints'] if name != joint]
    # A sentence without a joint's name speaks of them all: it stands below the table.
    left += [_cell(sentence) for sentence in report['cannot_tell']
             if joint in sentence and not any(name in sentence for name in others)]
    return '; '.join(left)


def _structure(least, most):
    """Return how much of what is left is structure: shares at least and at most, or None."""
    if least is None or most is None:
        return 'not known'
    if most < _WEIGHTY:
        return 'noise'
    return f'{_range(least, most, _percent)} % structure'


def _percent(share):
    return f'{100.0 * share:.0f}'


def of_all_joints(results):
    """Return the lines of what recordings cannot tell of any joint, sets with one reason once."""
    sets = {}
    for name, report in results.items():
        for sentence in () if isinstance(report, str) else report['cannot_tell']:
            if not any(joint in sentence for joint in report['joints']):
                sets.setdefault(_cell(sentence), []).append(name)
    return [f'- {", ".join(names)}: {sentence}' for sentence, names in sets.items()]


def loaded_rows(name, loads):
    """Return rows of loaded runs; loads: [(run, known mass, before, after)] [kg]."""
    return [f'| {name} | {run} | {mass:g} | {before:.3f} -> {after:.3f} | '
            f'{1e3 * (before - mass):.0f} -> {1e3 * (after - mass):.0f} |'
            for run, mass, before, after in loads]


def failed_row(name, sentence):
    """Return the row of a set that has no report, with the sentence that says why."""
    return f'| {name} | all | - | - | failed: {_cell(sentence)} | - | - |'


def table(results, again, loads=None, assumed=None):
    """
    Return the Markdown of {set: report, or the sentence of a set that failed}.

    again: the same with the parts exchanged; loads: {set: [(run, known mass, mass before, mass
    after)]} [kg]; assumed: {set: what load the model was made with, and why that is no
    knowledge}, empty where it is.
    """
    lines, cannot, loaded = list(HEAD), of_all_joints(results), []
    for name, result in results.items():
        if isinstance(result, str):
            lines.append(failed_row(name, result))
            continue
        lines += rows_of(name, result, again[name])
        loaded += loaded_rows(name, (loads or {}).get(name, ()))
    if cannot:
        lines += ['', 'Not to be told of any joint:', '', *cannot]
    told = [f'- {name}: {_cell(load)}' for name, load in (assumed or {}).items() if load]
    if told:
        lines += ['', 'Loads assumed, so that no error of a load is told:', '', *told]
    if loaded:
        lines += ['', *LOADED_HEAD, *loaded]
    return '\n'.join(lines) + '\n'
