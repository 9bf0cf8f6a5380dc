"""The report.json files of all sets as one Markdown table."""

HEAD = ('| set | joint | torque RMSE [Nm] | effects named |', '|---|---|---|---|')


def _number(value):
    return '-' if value is None else f'{value:.3g}'


def _cell(text):
    """Return text that cannot break a table's row."""
    return ' '.join(str(text).split()).replace('|', '/')


def _named(effect):
    others = ''.join(f' or `{name}`' for name in effect['alternatives'])
    return f'`{effect["name"]}`{others} ({effect["verdict"]})'


def rows_of(name, report):
    """Return a set's table rows; report: content of its report.json (DESIGN section 4)."""
    rows = []
    for joint, before, after in zip(report['joints'], report['before']['torque_rmse'],
                                    report['after']['torque_rmse']):
        effects = [_named(effect) for effect in report['effects'] if joint in effect['joints']]
        rows.append(f'| {name} | {joint} | {_number(before)} -> {_number(after)} | '
                    f'{", ".join(effects) or "none"} |')
    return rows


def failed_row(name, sentence):
    """Return the row of a set that has no report, with the sentence that says why."""
    return f'| {name} | all | - | failed: {_cell(sentence)} |'


def table(results):
    """Return the Markdown of {set: report, or the sentence of a set that failed}."""
    lines = list(HEAD)
    for name, result in results.items():
        lines += ([failed_row(name, result)] if isinstance(result, str)
                  else rows_of(name, result))
    return '\n'.join(lines) + '\n'
