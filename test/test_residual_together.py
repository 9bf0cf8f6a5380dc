"""Pairs of causes: possible ones only, each chosen with the other, never the same twice."""

import numpy as np
import pytest
from residual_helpers import constant_friction, declared_model, on, recorded, thinning, viscous

from hand_load_estimator.residual.doubts.unfounded import EXACT
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.candidate import ahead, Candidate, significant
from hand_load_estimator.residual.tracing.finer_shape import finer
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.together import _step, Together
from hand_load_estimator.residual.tracing.trace import Trace

NEEDED = 30.0


@pytest.fixture(scope='module')
def traced():
    """Return a Trace that knows every cause of a joint with viscous and Coulomb friction."""
    hidden = on(1, 6.0, viscous), on(1, 6.0, constant_friction)
    trace = Trace(declared_model(), find_residual(declared_model(), recorded(*hidden)), ())
    trace._evaluate()
    return trace


def search(trace, allowed=lambda hypothesis, score: True):
    singles = [c for c in trace._singles() if c.joints == [1] and c.name != 'base_tilt']
    return {c.name: c for c in singles}, Together(
        trace._model, trace.residual, (), trace.blocks, 1, set(), singles, allowed)


def names(steps):
    return {step.chosen.name for step in steps}


def test_the_two_that_are_there_stand_in_for_what_they_look_like(traced):
    singles, together = search(traced)
    steps = together.instead_of(singles['shear_thinning_friction'], NEEDED, traced.matters)
    assert names(steps) == {'viscous_friction', 'coulomb_friction'}
    # Each has what it gains beside the other, which is less than alone.
    for step in steps:
        assert NEEDED < step.chosen.gain < singles[step.chosen.name].gain


def test_two_that_physics_does_not_allow_beside_one_another_are_none(traced):
    singles, together = search(traced, lambda hypothesis, score: hypothesis.name not in (
        'viscous_friction', 'coulomb_friction'))
    steps = together.instead_of(singles['shear_thinning_friction'], NEEDED, traced.matters)
    assert not {'viscous_friction', 'coulomb_friction'} & names(steps)


def test_what_does_not_matter_is_no_part_of_a_pair(traced):
    singles, together = search(traced)
    assert together.instead_of(singles['shear_thinning_friction'], NEEDED,
                               lambda candidate: candidate.name != 'coulomb_friction') == ()


@pytest.mark.parametrize('share, more', [(0.5, False), (4.0, True)])
def test_what_a_plainer_form_leaves_is_no_second_cause(share, more):
    """Two explain more than one with its finer form by a share of what no formula is exact to."""
    trace = Trace(declared_model(), find_residual(
        declared_model(), recorded(on(1, 20.0, thinning))), ())
    trace._evaluate()
    singles, together = search(trace)
    chosen = singles['shear_thinning_friction']
    alone = finer(chosen, trace.blocks, trace._model, trace.residual, ())
    assert alone.gain > chosen.gain + 10.0 * NEEDED
    by_block = (1.0 + share * EXACT ** 2) * alone.by_block
    both = Candidate('both', alone.parts, by_block.sum(), 0.0, by_block)
    # Either is far more than chance, and far more than the plain form explains.
    assert ahead(both, alone).gain > NEEDED and significant(ahead(both, alone))
    assert together._beyond_form(both, chosen, NEEDED) == more


def test_nothing_is_searched_where_no_more_than_chance_is_left(traced, monkeypatch):
    singles, together = search(traced)
    monkeypatch.setattr(together, '_best', None)
    assert together.instead_of(singles['viscous_friction'], 1e9, traced.matters) == ()


def test_one_of_a_pair_gives_way_to_a_simpler_one_as_good_but_not_to_the_other():
    def candidate(name, size):
        hypothesis = Hypothesis(name, 1, {1: np.zeros((5, size))}, np.ones(size))
        by_block = np.full(40, 100.0) + size * np.tile([1.0, -1.0], 20)
        return Candidate(name, ((hypothesis, None),), by_block.sum(), 0.0, by_block)
    one, simpler = candidate('cable_drag', 5), candidate('torque_offset', 1)
    assert _step(one, [simpler], {'gravity_spring'}, NEEDED).chosen is simpler
    step = _step(one, [simpler], {'torque_offset'}, NEEDED)
    assert step.chosen is one and step.alternatives == (simpler,) and step.next_best is simpler


def test_a_true_single_effect_is_not_split(traced):
    trace = Trace(declared_model(), find_residual(
        declared_model(), recorded(on(1, 12.0, viscous))), ())
    assert names(trace.run()) == {'viscous_friction'}
