"""The result page of the effects suite: Markdown tables."""

from .document import markdown_table
from .effect_outcome import RIGHT
from .effect_recordings import DIAGNOSED, LOADED
from .effect_scores import (confusions, effect_rows, measured, pair_rows, totals, tried, verdicts)

_NONE = '-'


def effects_markdown(results, command, commit):
    """Return the page of all results as text."""
    total, ran = totals(results), measured(results)
    seconds = sum(part[2] for part in DIAGNOSED)
    parts = [
        '# Undeclared effects',
        f'{len(ran)} diagnoses of {len({r["plant"] for r in ran})} plants. Each plant has a model '
        'from recordings of it without the effect; then the effect is hidden in it, the tool told '
        f'nothing, and {seconds:.0f} s of no-load recordings are diagnosed. Errors are on other '
        f'recordings: torque without load, mass by `bayes` on {LOADED} runs with random known '
        'loads. Ratios are over the same plant without the effect, seen through its first model. '
        'A torque ratio is that of the joint where it is largest.',
        f'Command: `{command}`, commit {commit}. Seconds are wall clock of one process among as '
        'many as there are cores.',
        markdown_table(['goal', 'wanted', 'measured', 'reached'], [
            [what, goal, value, 'yes' if good else '**no**']
            for what, goal, value, good in verdicts(total)]),
        '## One effect', _effects_table(results),
        f'Where the right effect was confirmed, {total["false_beside"]} others were confirmed '
        f'beside it; {total["both_named"]} counted as right by naming both of an inseparable '
        'pair with the motion that separates them (strengths 2 and 5).',
        '## Figures of the effects found', _parameter_table(results),
        '## Confirmed in place of the right one', _confusion_table(results),
        '## Two effects', _pair_table(results), *_left_out(results)]
    return '\n\n'.join(parts) + '\n'


def _counts(counts):
    return ', '.join(f'{name} {count}' for name, count in counts.items()) or _NONE


def _arrow(figures, digits=1):
    if figures is None:
        return _NONE
    return ' -> '.join(f'{figures[when]:.{digits}f}' for when in ('before', 'after'))


def _mass(row):
    if row['mass'] is None:
        return [_NONE, _NONE]
    return [' -> '.join(f'{row["mass"][when][moment]:.1f}' for when in ('before', 'after'))
            for moment in row['mass']['before']]


def _effects_table(results):
    rows = []
    for row in effect_rows(results):
        right = sum(row['outcomes'].get(outcome, 0) for outcome in RIGHT)
        joint = f'{row["joint_right"]} of {row["joints"]}' if row['joints'] else 'arm'
        seconds = _NONE if row['seconds'] is None else f'{row["seconds"]:.0f}'
        rows.append([f'`{row["name"]}`', f'{row["strength"]:g}', f'{right} of {row["cases"]}',
                     _counts(row['outcomes']), joint, _counts(row['false']),
                     _arrow(row['torque'], 2), *_mass(row), seconds])
    head = ['effect', 'strength', 'right', 'outcome', 'joint right', 'false beside',
            'torque, x no effect', 'mass at 3 s, x', 'mass at the end, x', 's']
    return markdown_table(head, rows)


def _parameter_table(results):
    rows = [[f'`{row["name"]}`', f'{row["strength"]:g}', name, f'{100.0 * error:.0f}']
            for row in effect_rows(results) for name, error in row['parameters'].items()]
    return markdown_table(['effect', 'strength', 'figure', 'median error [% of truth]'], rows)


def _confusion_table(results):
    return markdown_table(['hidden', 'confirmed'], [
        [f'`{name}`', _counts(counts)] for name, counts in confusions(results).items()])


def _pair_table(results):
    return markdown_table(['plant', 'hidden', 'outcome', 'false beside'], [
        [str(row['plant']), ', '.join(f'`{name}`' for name in row['names']),
         ', '.join(row['outcomes']), ', '.join(row['false']) or _NONE]
        for row in pair_rows(results)])


def _left_out(results):
    """Return what could not be made and what failed, each with its reason."""
    skipped = [f'- {r["label"]}: {r["skipped"]}' for r in results if 'skipped' in r]
    failed = [f'- {r["label"]}: {r["failed"]}' for r in tried(results) if 'failed' in r]
    return [text for title, lines in (('## Not possible in the plant', skipped),
                                      ('## Failed (counted as missed)', failed))
            if lines for text in (title, '\n'.join(lines))]
