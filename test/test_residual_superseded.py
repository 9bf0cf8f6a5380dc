"""What a later effect explains by itself, in a finer form than it was chosen with."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import (constant_friction, declared_model, on, peak, recorded, ripple,
                              thinning, viscous)

from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing import superseded
from hand_load_estimator.residual.tracing.candidate import single, Step
from hand_load_estimator.residual.tracing.finer_shape import best_of_each, search_around
from hand_load_estimator.residual.tracing.found import Found
from hand_load_estimator.residual.tracing.hypotheses import of_joint
from hand_load_estimator.residual.tracing.superseded import take_back

JOINT, NEEDED = 1, 30.0


def found_one_after_the_other(names, *hidden):
    """Return model and Found with effects of JOINT, each chosen beside those before it."""
    model = declared_model()
    residual = find_residual(model, recorded(*hidden)[:-1])
    found = Found(model, residual, (), None, lambda candidate: True)
    for name in names:
        blocks = found.blocks()
        asked = [h for h in of_joint(model, residual, blocks, (), JOINT) if h.name == name]
        (best,) = best_of_each(asked, blocks)[0].values()
        best, _ = search_around(best, blocks, model, residual)
        found.add(Step(single(*best), (), None, NEEDED))
    return model, found


def names(found):
    return [step.chosen.name for step in found.steps]


def misfit(found):
    return found.blocks().misfit(JOINT).sum()


def test_what_a_lubricant_that_thins_gently_explains_alone_is_taken_back():
    chosen = ['viscous_friction', 'shear_thinning_friction']
    model, found = found_one_after_the_other(chosen, on(JOINT, 12.0, thinning))
    assert found.steps[1].chosen.parts[0][0].shape['exponent'] == 1.0
    before = misfit(found)
    assert take_back(found, model, (), lambda candidate: True) == {JOINT}
    assert names(found) == ['shear_thinning_friction']
    assert found.steps[0].chosen.parts[0][0].shape['exponent'] < 0.9
    # Two halves of it explained no more.
    explained = np.subtract(*(found.beside(found.steps[0]).misfit(JOINT).sum(), misfit(found)))
    assert misfit(found) - before < 0.01 * explained


@pytest.mark.parametrize('chosen, hidden', [
    (['viscous_friction', 'stribeck_friction'], (viscous, peak)),
    (['coulomb_friction', 'shear_thinning_friction'], (constant_friction, thinning)),
    (['torque_ripple', 'shear_thinning_friction'], (ripple, thinning))])
def test_two_that_are_there_stay_two(chosen, hidden):
    model, found = found_one_after_the_other(chosen, *(on(JOINT, 8.0, one) for one in hidden))
    assert take_back(found, model, (), lambda candidate: True) == set()
    assert names(found) == chosen


def test_nothing_impossible_takes_the_place_of_two():
    chosen = ['viscous_friction', 'shear_thinning_friction']
    model, found = found_one_after_the_other(chosen, on(JOINT, 12.0, thinning))
    assert take_back(found, model, (), lambda candidate: False) == set()
    assert names(found) == chosen


def test_nothing_is_taken_back_for_more_figures(monkeypatch):
    """More of them explain as much of what is none of their own."""
    chosen = ['viscous_friction', 'shear_thinning_friction']
    model, found = found_one_after_the_other(chosen, on(JOINT, 12.0, thinning))
    alone = superseded.searched_again

    def with_two_more(*given):
        candidate = alone(*given)
        (hypothesis, score), = candidate.parts
        more = replace(hypothesis, scale=np.ones(len(hypothesis.scale) + 2))
        return replace(candidate, parts=((more, score),))
    monkeypatch.setattr(superseded, 'searched_again', with_two_more)
    assert take_back(found, model, (), lambda candidate: True) == set()
    assert names(found) == chosen


def test_presliding_is_not_taken_back():
    """It shows in reversals, which the blocks leave out."""
    chosen = ['presliding_hysteresis', 'shear_thinning_friction']
    model, found = found_one_after_the_other(chosen, on(JOINT, 12.0, thinning))
    assert take_back(found, model, (), lambda candidate: True) == set()
    assert names(found) == chosen
