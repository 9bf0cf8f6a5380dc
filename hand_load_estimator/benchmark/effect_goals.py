"""The goals of issue 3 for undeclared effects, judged on the totals of a suite."""

import numpy as np

from .effect_cases import ALONE, BLIND, CLEAN
from .share import share_text

# Torque and mass error over those of the same plant without the effect; seconds of a diagnosis.
TORQUE_GOAL, MASS_GOAL, SECONDS_GOAL = 1.15, 1.5, 180.0
# Fewer say too little of false findings.
CLEAN_SETS = 20
EVERY = 'every case'


def verdicts(total):
    """
    Return (what, goal, value, reached) of the goals issue 3 states, where measured.

    reached: None where something is only told.
    """
    rows = [_share('right effect and joint, one effect, strength 2 and 5', total['single'], 90),
            _share('the same, and nothing false confirmed beside', total['single_alone'], 90),
            _share('the same as the first, counting also answers that name the right cause and '
                   'one that these recordings cannot tell from it', total['single_widely'], 90),
            _share('both of a pair right', total['pairs'], 75),
            _share('the same, counting such answers too', total['pairs_widely'], 75),
            _share('both of a pair on one joint right', total['same_joint'], 75),
            _share('right effect and all joints, one effect of the same size on all joints',
                   total['common'], 90),
            _share('outside the vocabulary: `unknown` confirmed with its joint and variable',
                   total['outside'], 100),
            _share('contact or load change: named or kept out of the model', total['kept_out'],
                   100)]
    rows += [_clean('confirmed on clean plants', total['clean']),
             _suspected('only suspected on them, and in the model all the same',
                        total['suspected'][CLEAN]),
             _clean('confirmed where nothing is hidden and no temperature was recorded',
                    total['blind']),
             _suspected('only suspected there, likewise', total['suspected'][BLIND]),
             _clean('confirmed where nothing is hidden and one recording of 44 s is all',
                    total['alone']),
             _suspected('only suspected in one recording, likewise', total['suspected'][ALONE])]
    confirmed, false = total['confirmed']
    rows.append(('false among all findings confirmed, any strength', 'told',
                 share_text(false, confirmed), None) if confirmed else None)
    if total['ratios']:
        rows += [*_torque(total), *_mass(total), *_mass_per_case(total)]
    if total['together']:
        rows += _together(total['together'])
    if total['seconds']:
        worst = max(total['seconds'])
        rows.append(('seconds per diagnosis, median and longest', f'<= {SECONDS_GOAL:g}',
                     f'{np.median(total["seconds"]):.0f}, {worst:.0f}', worst <= SECONDS_GOAL))
    return [row for row in rows if row]


def _clean(what, counts):
    clean, false = counts
    few = '' if clean >= CLEAN_SETS else ', too few to tell'
    return (what, f'<= 1 on {CLEAN_SETS}', f'{false} on {clean}{few}',
            false <= 1 and not few) if clean else None


def _suspected(what, found):
    """Return the row of effects suspected where nothing is hidden, with what they cost."""
    if not found['of']:
        return None
    told = f'{found["count"]} in {found["sets"]} of {found["of"]}'
    if found['sets']:
        masses = ', '.join(f'{ratio:.2f} x at {moment}'
                           for moment, ratio in found['mass'].items())
        told += (f'; there torque error after over before, at its worst joint: median '
                 f'{np.median(found["torque"]):.2f} x, worst {max(found["torque"]):.2f} x; mass '
                 f'RMSE {masses}')
    return what, 'told', told, None


def _share(what, counts, goal):
    cases, right = counts
    if not cases:
        return None
    return what, f'>= {goal} %', share_text(right, cases), 100.0 * right >= goal * cases


def beyond(total, figure, goal):
    """Return the cases whose `figure` stays above a goal, worst first."""
    return sorted((case for case in total['ratios'] if not case[figure]['after'] <= goal),
                  key=lambda case: -case[figure]['after'])


def _every(what, total, figure, goal):
    """Return the row of a goal that each single case has to reach by itself."""
    after, before = ([case[figure][when] for case in total['ratios']]
                     for when in ('after', 'before'))
    what, wanted, value, reached = _each(what, after, goal, total['failed'])
    return what, wanted, f'{value}; median before {np.median(before):.2f} x', reached


def _each(what, after, goal, failed=0):
    """
    Return the row of a goal that each of some ratios has to reach by itself.

    failed: cases without a ratio, because their diagnosis failed.
    """
    within, cases = sum(ratio <= goal for ratio in after), len(after) + failed
    return (what, EVERY, f'{share_text(within, cases)}; median {np.median(after):.2f} x, '
            f'worst {max(after):.2f} x', within == cases)


def _together(errors):
    """Return the rows of cases of two effects, or of one on all joints."""
    of = 'two effects at once, or one of the same size on all joints'
    return [_each(f'{of}: torque error within {TORQUE_GOAL:g} x of no effect',
                  [case['torque']['after'] for case in errors], TORQUE_GOAL),
            *(_each(f'{of}: mass RMSE, {moment}, within {MASS_GOAL:g} x of no effect',
                    [case['mass'][moment] for case in errors], MASS_GOAL)
              for moment in errors[0]['mass'])]


def _torque(total):
    """Return the rows of torque error, over no effect and over the effect known."""
    return (_every(f'torque error at its worst joint within {TORQUE_GOAL:g} x of no effect '
                   '(single, strength 2 and 5)', total, 'torque', TORQUE_GOAL),
            _every(f'the same within {TORQUE_GOAL:g} x of what is left where the effect is known',
                   total, 'seen', TORQUE_GOAL))


def _mass(total):
    """Return the rows of mass error over the same plants without the effects, pooled."""
    return [(f'mass RMSE, {moment}, over no effect (the same cases, pooled)',
             f'<= {MASS_GOAL:g} x', f'{ratio:.2f} x (before {total["mass_before"][moment]:.1f} x)',
             ratio <= MASS_GOAL) for moment, ratio in total['mass'].items()]


def _mass_per_case(total):
    return [_every(f'mass RMSE, {moment}, of each case within {MASS_GOAL:g} x of no effect', total,
                   f'mass at {moment}', MASS_GOAL) for moment in total['mass']]
