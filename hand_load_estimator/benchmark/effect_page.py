"""The result page of the effects suite: Markdown tables."""

from .document import markdown_table
from .effect_cases import PAIR, SAME_JOINT
from .effect_goals import beyond, MASS_GOAL, TORQUE_GOAL, verdicts
from .effect_outcome import FREQUENCY_OFF, RIGHT, UNTOLD
from .effect_recordings import DIAGNOSED, LOADED
from .effect_scores import (common_rows, confusions, effect_rows, ENOUGH_ROWS, measured, not_tried,
                            only_widely, pair_rows, totals, tried, WITHIN)
from .share import share_text

_NONE = '-'
# Share of a joint's rows in motion below which a case is named.
MOST_ROWS = 0.8
_CASE = ('effect', 'strength', 'joint', 'plant', 'outcome')
_ERRORS = ('torque, x no effect', 'mass after, 3 s and end, x', 's')
_KNOWN = (
    'What is left where the effect is known: the first model\'s error of the torque that the arm '
    'would report along the same true motion without the effect, carried through gains and '
    'delays, on rows in which a joint moves that has turned by twice its presliding travel since '
    'the recording began. A gain scales what no model explains; a delay shows torque of a joint '
    'that stood; how friction began nobody saw. A diagnosis may do better: it identifies all else '
    'anew.')
_HOW_JUDGED = (
    'Right means confirmed by name at its joint and no other, or, for the sets of section 4 of '
    'the design, both named at that joint with the motion that would separate them, where the one '
    f'confirmed is less than {UNTOLD:g} standard errors ahead of the other. What comes from '
    'outside (`external_contact`, `load_change`) is right by name only; that it was kept out of '
    'the model is a row of its own. One row also counts naming both for two kinds of pair that '
    'the design does not list: '
    '`torque_offset` beside `friction_asymmetry`, which differ only where a joint reverses before '
    'its contacts slide; and the inertia of rotor and first link of an upright arm, where the '
    'report says that no motion separates them. Outside the vocabulary, only a confirmed '
    '`unknown` counts, at the right joint and with the variable it depends on and no other: for '
    'a swinging load time with the frequency at which it swings, to '
    f'{100.0 * FREQUENCY_OFF:.0f} %. Contacts and load changes are in the recordings that errors '
    'are taken on, too, and not in the error goals. 95 % intervals are Wilson\'s, as if cases '
    'were drawn independently.')


def effects_markdown(results, command, commit, cases=()):
    """Return the page of results as text; cases: the EffectCases that belong to a whole run."""
    total, ran = totals(results), measured(results)
    seconds = sum(part[2] for part in DIAGNOSED)
    parts = [
        '# Undeclared effects', *_broken_off(results, cases),
        f'{len(ran)} diagnoses of {len({r["plant"] for r in ran})} plants. Each plant has a model '
        'from recordings of it without the effect; then the effect is hidden in it, the tool told '
        f'nothing, and {seconds:.0f} s of no-load recordings are diagnosed. Errors are on other '
        f'recordings: torque without load, mass by `bayes` on {LOADED} runs with random known '
        'loads (no other parameter, no other method). Ratios are over the same plant without '
        'the effect, seen through its first model, which knows its own recordings only: the '
        'model after a diagnosis knows those and the diagnosed ones. '
        'A torque ratio is that of the joint where it is largest.', _KNOWN + _judged(ran),
        f'Command: `{command}`, commit {commit}. Seconds are wall clock of the diagnosis alone, '
        'after recordings were read and filtered, in one process among as many as there are '
        'cores.',
        markdown_table(['goal', 'wanted', 'measured', 'reached'], [
            [what, goal, value, {True: 'yes', False: '**no**', None: _NONE}[good]]
            for what, goal, value, good in verdicts(total)]),
        _HOW_JUDGED, *_only_widely(results), *_beyond(total),
        '## One effect', _effects_table(results),
        f'Where the right effect was confirmed, {total["false_beside"]} others were confirmed '
        f'beside it; {total["both_named"]} counted as right by naming both (strengths 2 and 5).',
        '## Figures of the effects found', *_within(results), _parameter_table(results),
        '## Confirmed in place of the right one', _confusion_table(results),
        '## Two effects', _pair_table(pair_rows(results, PAIR)),
        '## Two effects on one joint', _pair_table(pair_rows(results, SAME_JOINT)),
        '## One effect of the same size on all joints', _common_table(results),
        *_left_out(results)]
    return '\n\n'.join(parts) + '\n'


def _judged(ran):
    """Return a sentence on the cases of which few rows are judged so."""
    few = [r['label'] for r in ran if min(r['seen']['share']) < MOST_ROWS]
    return '' if not few else (
        f' Less than {100.0 * MOST_ROWS:.0f} % of a joint\'s rows in motion were judged in '
        f'{len(few)} of {len(ran)} cases: {", ".join(few)}; below '
        f'{100.0 * ENOUGH_ROWS:.0f} % at the effect\'s own joint a case counts as not reached.')


def _broken_off(results, cases):
    """Return what is missing of a run that did not get to its end."""
    if len(results) >= len(cases):
        return []
    missing = [f'`{name}` ({", ".join(f"{s:g}" for s in strengths)})'
               for name, strengths in not_tried(results, cases)]
    without = (f'No case yet, of strength 2 and above: {", ".join(missing)}.' if missing else
               'Every effect has a case of strength 2 and of 5.')
    return [f'**Broken off: {len(results)} of {len(cases)} cases.** {without}']


def _only_widely(results):
    pairs = [f'`{hidden}` where `{named}` was confirmed: {count}'
             for (hidden, named), count in only_widely(results).items()]
    return [f'Right by more pairs than the design has: {"; ".join(pairs)}.'] if pairs else []


def _beyond(total):
    """Return the cases whose torque or mass error stays beyond its goal."""
    out = []
    torque = beyond(total, 'torque', TORQUE_GOAL)
    torque += [c for c in beyond(total, 'seen', TORQUE_GOAL) if c not in torque]
    if torque:
        out += [f'## Torque error beyond {TORQUE_GOAL:g} x', markdown_table(
            [*_CASE, 'before, x no effect', 'after, x no effect', 'after, x effect known'],
            [[*_case(c), f'{c["torque"]["before"]:.2f}', f'{c["torque"]["after"]:.2f}',
              f'{c["seen"]["after"]:.2f}'] for c in torque])]
    for moment in total['mass']:
        mass = beyond(total, f'mass at {moment}', MASS_GOAL)
        if mass:
            out += [f'## Mass error, {moment}, beyond {MASS_GOAL:g} x of no effect',
                    f'RMSE of the {LOADED} loaded runs of a case: so few that chance alone moves '
                    'the ratio.',
                    markdown_table(
                        [*_CASE, 'before [g]', 'after [g]', 'no effect [g]', 'after, x'],
                        [_mass_row(c, moment) for c in mass])]
    return out


def _mass_row(case, moment):
    rmse = case['mass_rmse'][moment]
    return [*_case(case), *(f'{1e3 * rmse[when]:.1f}' for when in ('before', 'after', 'without')),
            f'{case[f"mass at {moment}"]["after"]:.2f}']


def _case(case):
    return [f'`{case["name"]}`', f'{case["strength"]:g}', ', '.join(case['joints']) or 'arm',
            str(case['plant']), case['outcome']]


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
    rows = [[f'`{row["name"]}`', f'{row["strength"]:g}', name, f'{100.0 * of["error"]:.0f}',
             f'{of["within"]} of {of["stated"]}' if of['stated'] else _NONE,
             str(of['found'] - of['stated'])]
            for row in effect_rows(results) for name, of in row['parameters'].items()]
    return markdown_table(['effect', 'strength', 'figure', 'median error [% of truth]',
                           f'truth within {WITHIN:g} std', 'no std stated'], rows)


def _within(results):
    """Return a sentence on how often the truth lies where the reports say."""
    figures = [of for row in effect_rows(results) for of in row['parameters'].values()]
    stated, within, found = (sum(of[key] for of in figures)
                             for key in ('stated', 'within', 'found'))
    if not stated:
        return []
    return [f'Truth within {WITHIN:g} standard deviations: {share_text(within, stated)} of the '
            f'figures with one, 95.4 % expected; {found - stated} of {found} have none.']


def _confusion_table(results):
    rows = [[f'`{name}`', _counts(counts)] for name, counts in confusions(results).items()]
    return markdown_table(['hidden', 'confirmed'], rows) if rows else 'None.'


def _pair_table(rows):
    return markdown_table(['plant', 'hidden', 'joints', 'outcome', 'false beside', *_ERRORS], [
        [str(row['plant']), ', '.join(f'`{name}`' for name in row['names']),
         ', '.join(dict.fromkeys(row['joints'])), ', '.join(row['outcomes']),
         ', '.join(row['false']) or _NONE, *_one_error(row['errors'])] for row in rows])


def _common_table(results):
    return markdown_table(['plant', 'hidden', 'strength', 'outcome', 'false beside', *_ERRORS], [
        [str(row['plant']), f'`{row["name"]}`', f'{row["strength"]:g}', row['outcome'],
         ', '.join(row['false']) or _NONE, *_one_error(row['errors'])]
        for row in common_rows(results)])


def _one_error(errors):
    if errors is None:
        return [_NONE] * len(_ERRORS)
    return [_arrow(errors['torque'], 2),
            ', '.join(f'{ratio:.2f}' for ratio in errors['mass'].values()),
            f'{errors["seconds"]:.0f}']


def _left_out(results):
    """Return what could not be made and what failed, each with its reason."""
    skipped = [f'- {r["label"]}: {r["skipped"]}' for r in results if 'skipped' in r]
    failed = [f'- {r["label"]}: {r["failed"]}' for r in tried(results) if 'failed' in r]
    return [text for title, lines in (('## Not possible in the plant', skipped),
                                      ('## Failed (counted as missed)', failed))
            if lines for text in (title, '\n'.join(lines))]
