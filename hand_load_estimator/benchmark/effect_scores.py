"""From the results of all cases to a row per effect and strength, and the totals of a suite."""

from collections import Counter

import numpy as np

from ..residual.diagnosis import CONFIRMED, SUSPECTED
from .effect_cases import (ALONE, BLIND, CLEAN, COMMON, FROM_OUTSIDE, MEDIUM, OUTSIDE, PAIR,
                           SAME_JOINT, SINGLE)
from .effect_errors import MASS_MOMENTS
from .effect_outcome import BOTH, FOUND, judge, kept_out, RIGHT

# Share of a joint's rows in motion that must be judged.
ENOUGH_ROWS = 0.2
# Standard deviations within which a figure's truth is expected 95 times in 100.
WITHIN = 2.0


def measured(results):
    """Return the results of cases that could be made and did not fail."""
    return [r for r in results if 'skipped' not in r and 'failed' not in r]


def tried(results):
    """Return the results of cases that could be made."""
    return [r for r in results if 'skipped' not in r]


def torque_ratio(result, when):
    """Return RMSE over that of the plant without the effect, at the joint where it is largest."""
    torque = result['torque']
    return float(np.max(np.array(torque[when]) / np.array(torque['without'])))


def seen_ratio(result, when):
    """
    Return RMSE over what is left where the effect is known (effect_floor.py), likewise.

    On rows of the Floors; joints with few are left out, and a case whose own joint is one of them
    is not judged: no number.
    """
    seen = {key: np.array(value) for key, value in result['seen'].items()}
    own = np.isin(seen['joints'], [name for effect in result['effects']
                                   for name in effect['joints']])
    there = seen['share'] >= ENOUGH_ROWS
    if not there[own].all() or not there.any():
        return float('nan')
    return float(np.max(seen[when][there] / seen['known'][there]))


def mass_ratio(results, when, moment):
    """Return mass RMSE over that of the plants without the effects, all runs together."""
    errors, without = ([e for r in results for e in r['mass'][key][moment]]
                       for key in (when, 'without'))
    return _rms(errors) / max(_rms(without), 1e-12)


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float('nan')


def _of_kind(results, kind):
    return [r for r in results if r['kind'] == kind]


def effect_rows(results):
    """Return a row of figures per effect and strength, sorted, of single and outside cases."""
    rows, groups = [], {}
    for result in tried(results):
        if result['kind'] in (SINGLE, OUTSIDE):
            (effect,) = result['effects']
            groups.setdefault((effect['name'], effect['strength']), []).append(result)
    for (name, strength), group in sorted(groups.items()):
        rows.append({'name': name, 'strength': strength, **_outcomes(group), **_errors(group)})
    return rows


def _outcomes(group):
    outcomes, joints, false = Counter(), [], Counter()
    for result in group:
        (effect,), wrong = judge(result)
        outcomes[effect['outcome']] += 1
        joints += [] if effect['joint_right'] is None else [effect['joint_right']]
        false.update(wrong)
    return {'cases': len(group), 'outcomes': dict(outcomes), 'joint_right': int(sum(joints)),
            'joints': len(joints), 'false': dict(false)}


def _errors(group):
    """Return medians of torque ratios and seconds, mass ratios of all runs, figures' errors."""
    group = measured(group)
    if not group:
        return {'torque': None, 'mass': None, 'seconds': None, 'parameters': {}}
    return {
        'torque': {when: float(np.median([torque_ratio(r, when) for r in group]))
                   for when in ('before', 'after')},
        'mass': {when: {moment: mass_ratio(group, when, moment) for moment in MASS_MOMENTS}
                 for when in ('before', 'after')},
        'mass_rmse': {when: {moment: _rms([e for r in group for e in r['mass'][when][moment]])
                             for moment in MASS_MOMENTS}
                      for when in ('before', 'after', 'without')},
        'seconds': float(np.median([r['seconds'] for r in group])),
        'parameters': _parameter_errors(group)}


def _parameter_errors(group):
    """
    Return {parameter: {error, within, stated, found}} of the effects found.

    error: median |estimate - truth| / |truth|; found: figures; stated: those with a standard
    deviation; within: those of them that lie within WITHIN of it of the truth.
    """
    figures = {}
    for result in group:
        (effect,), _ = judge(result)
        for figure in result['parameters'] if effect['outcome'] == FOUND else ():
            off = abs(figure['estimate'] - figure['truth'])
            figures.setdefault(figure['parameter'], []).append(
                (off / max(abs(figure['truth']), 1e-12), off, figure['std']))
    return {name: {'error': float(np.median([share for share, _, _ in those])),
                   'found': len(those), 'stated': sum(std is not None for *_, std in those),
                   'within': sum(std is not None and off <= WITHIN * std
                                 for _, off, std in those)}
            for name, those in figures.items()}


def confusions(results):
    """Return {hidden effect: {what was confirmed in its place: count}} of single cases."""
    out = {}
    for result in _of_kind(tried(results), SINGLE):
        (effect,), false = judge(result)
        if effect['outcome'] not in RIGHT and false:
            out.setdefault(effect['name'], Counter()).update(false)
    return {name: dict(counts) for name, counts in out.items()}


def pair_rows(results, kind=PAIR):
    """Return a row per pair of a kind: names, joints, outcomes, false findings, errors."""
    rows = []
    for result in _of_kind(tried(results), kind):
        effects, false = judge(result)
        rows.append({'plant': result['plant'], 'names': [e['name'] for e in effects],
                     'joints': [joint for e in result['effects'] for joint in e['joints']],
                     'outcomes': [e['outcome'] for e in effects], 'false': false,
                     'errors': None if 'failed' in result else _one_error(result)})
    return rows


def _one_error(result):
    """Return a measured case's torque ratios, mass ratios after it, and seconds."""
    return {'torque': {when: torque_ratio(result, when) for when in ('before', 'after')},
            'mass': {moment: mass_ratio([result], 'after', moment) for moment in MASS_MOMENTS},
            'seconds': result['seconds']}


def common_rows(results):
    """Return a row per effect on all joints: outcome, what is false beside it, ratios."""
    rows = []
    for result in _of_kind(measured(results), COMMON):
        (effect,), false = judge(result)
        rows.append({'plant': result['plant'], **effect, 'false': false,
                     'errors': _one_error(result)})
    return rows


def _medium(results):
    """Return the single cases that the goals speak of."""
    return [r for r in _of_kind(tried(results), SINGLE)
            if r['effects'][0]['strength'] >= MEDIUM]


def _from_outside(result):
    return result['effects'][0]['name'] in FROM_OUTSIDE


def totals(results):
    """Return the counts and ratios that the goals speak of."""
    outside = [r for r in _of_kind(tried(results), SINGLE) if _from_outside(r)]
    effects = _medium(results)
    ran = [r for r in measured(effects) if not _from_outside(r)]
    return {
        'single': _right(effects), 'single_alone': _right(effects, alone=True),
        'single_widely': _right(effects, widely=True),
        'kept_out': [len(outside), sum(map(kept_out, outside))],
        'pairs': _right(_of_kind(tried(results), PAIR)),
        'pairs_widely': _right(_of_kind(tried(results), PAIR), widely=True),
        'same_joint': _right(_of_kind(tried(results), SAME_JOINT)),
        'common': _right(_of_kind(tried(results), COMMON)),
        'outside': _right(_of_kind(tried(results), OUTSIDE)),
        'clean': _found_in(_of_kind(measured(results), CLEAN)),
        'blind': _found_in(_of_kind(measured(results), BLIND)),
        'alone': _found_in(_of_kind(measured(results), ALONE)),
        'suspected': {kind: _suspected_in(_of_kind(measured(results), kind))
                      for kind in (CLEAN, BLIND, ALONE)},
        'confirmed': _confirmed(measured(results)),
        'both_named': sum(judge(r)[0][0]['outcome'] == BOTH for r in effects),
        'false_beside': sum(len(judge(r)[1]) for r in effects
                            if judge(r)[0][0]['outcome'] in RIGHT),
        'ratios': [_ratios(r) for r in ran],
        'failed': sum('failed' in r and not _from_outside(r) for r in effects),
        'together': [_one_error(r) for r in measured(results)
                     if r['kind'] in (PAIR, SAME_JOINT, COMMON)],
        'mass': {moment: mass_ratio(ran, 'after', moment) for moment in MASS_MOMENTS}
        if ran else {},
        'mass_before': {moment: mass_ratio(ran, 'before', moment) for moment in MASS_MOMENTS}
        if ran else {},
        'seconds': [r['seconds'] for r in measured(results)]}


def _found_in(results):
    """Return [sets in which nothing is hidden, effects confirmed in them]."""
    return [len(results), sum(len(judge(r)[1]) for r in results)]


def _suspected_in(results):
    """
    Return what sets in which nothing is hidden have of effects only suspected, and its price.

    of, sets: all of them, and those with such findings and none confirmed, of which the rest is;
    count: findings; torque: of each, RMSE after over before at the joint where that is largest;
    mass {moment: likewise, all runs together}.
    """
    own = [r for r in results if r['findings']
           and all(f['verdict'] == SUSPECTED for f in r['findings'])]
    return {'of': len(results), 'sets': len(own), 'count': sum(len(r['findings']) for r in own),
            'torque': [float(np.max(np.divide(r['torque']['after'], r['torque']['before'])))
                       for r in own],
            'mass': {moment: mass_ratio(own, 'after', moment) / mass_ratio(own, 'before', moment)
                     for moment in MASS_MOMENTS} if own else {}}


def _confirmed(results):
    """Return [findings confirmed, those of them that nothing hidden explains]."""
    return [sum(f['verdict'] == CONFIRMED for r in results for f in r['findings']),
            sum(len(judge(r)[1]) for r in results)]


def _ratios(result):
    """Return a single case's errors over those without its effect, and whether it was found."""
    (effect,), _ = judge(result)
    return {'name': effect['name'], 'strength': effect['strength'], 'plant': result['plant'],
            'joints': result['effects'][0]['joints'], 'outcome': effect['outcome'],
            'torque': {when: torque_ratio(result, when) for when in ('before', 'after')},
            'seen': {when: seen_ratio(result, when) for when in ('before', 'after')},
            **{f'mass at {moment}': {when: mass_ratio([result], when, moment)
                                     for when in ('before', 'after')} for moment in MASS_MOMENTS},
            'mass_rmse': {moment: {when: _rms(result['mass'][when][moment])
                                   for when in ('before', 'after', 'without')}
                          for moment in MASS_MOMENTS}}


def only_widely(results):
    """Return {(hidden effect, confirmed one): cases} that only the wide count takes for right."""
    pairs = Counter()
    for result in _medium(results):
        (wide,), beside = judge(result, widely=True)
        (effect,), false = judge(result)
        if wide['outcome'] in RIGHT and effect['outcome'] not in RIGHT:
            pairs.update((wide['name'], name) for name in set(false) - set(beside))
    return dict(pairs)


def not_tried(results, cases):
    """Return [(effect, strengths)] of the EffectCases of one effect of which none has a result."""
    there = {r['label'] for r in results}
    groups = {}
    for case in cases:
        if case.kind == SINGLE and case.hidden[0].strength >= MEDIUM:
            (hidden,) = case.hidden
            groups.setdefault((hidden.name, hidden.strength), []).append(case.label in there)
    out = {}
    for (name, strength), known in groups.items():
        if not any(known):
            out.setdefault(name, []).append(strength)
    return list(out.items())


def _right(results, widely=False, alone=False):
    """Return [cases, those in which every hidden effect is right]; alone: and nothing false."""
    judged = [judge(result, widely) for result in results]
    right = [all(e['outcome'] in RIGHT for e in effects) and not (alone and false)
             for effects, false in judged]
    return [len(right), int(sum(right))]
