"""How friction turns is asked where it turns: with the travel that each way of turning wants."""

import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded

from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.candidate import single
from hand_load_estimator.residual.tracing.finer_shape import (best_of_each, finer, search_around,
                                                              searched_again)
from hand_load_estimator.residual.tracing.hypotheses import hypotheses, of_shapes, released
from hand_load_estimator.residual.tracing.hypothesis import searched as off_default

NAME, JOINT = 'presliding_hysteresis', 1
TRAVEL, PLASTIC = 6e-3, 0.8
# Travel [rad], plastic, velocity [rad/s], exponent, range [K] of a Stribeck peak.
PEAK = 1.5e-3, 0.6, 0.065, 1.3, 240.0


def turning(run):
    """Friction that turns over a longer way than declared, and then is at its level."""
    return run.x.shown(np.arange(run.robot.n), TRAVEL, PLASTIC) - run.x.z


def peak(run):
    """A Stribeck peak, every figure of whose form is a little off its default."""
    return run.x.shown(np.arange(run.robot.n), *PEAK)


def figures(hypothesis):
    return set(off_default(hypothesis))


def searched(effect, times, name):
    """Return model, Residual, Blocks and the best Candidate of an effect's plainest form."""
    model = declared_model()
    residual = find_residual(model, recorded(on(JOINT, times, effect))[:-1])
    blocks = residual.blocks()
    plain = [h for h in hypotheses(model, residual, blocks, ())
             if (h.name, h.joint) == (name, JOINT) and h.shape['plastic'] == BOTH]
    (pair,) = best_of_each(plain, blocks)[0].values()
    best, _ = search_around(pair, blocks, model, residual)
    return model, residual, blocks, single(*best)


@pytest.fixture(scope='module')
def turned():
    """Return what `searched` does of friction that never quite turns by its plainest form."""
    return searched(turning, 6.0, NAME)


@pytest.fixture(scope='module')
def peaked():
    """Return what `searched` does of a Stribeck peak."""
    return searched(peak, 20.0, 'stribeck_friction')


def test_all_figures_of_a_form_are_found_together(peaked):
    model, residual, blocks, plain = peaked
    shape = finer(plain, blocks, model, residual, (JOINT,)).parts[0][0].shape
    names = 'travel', 'plastic', 'stribeck_velocity', 'exponent', 'velocity_range'
    for name, true in zip(names, PEAK):
        assert shape[name] == pytest.approx(true, rel=0.25), name


def test_figures_at_their_defaults_are_released_to_be_searched(peaked):
    """Only of what is off its default a step is tried."""
    model, residual, _, candidate = peaked
    plain = candidate.parts[0][0]
    (free,) = released(plain, model, residual, True)
    assert figures(plain) == {'stribeck_velocity'}
    assert figures(free) == {'stribeck_velocity', 'exponent', 'velocity_range'}
    (cold,) = released(plain, model, residual, False)
    assert figures(cold) == {'stribeck_velocity', 'exponent'}
    (own,) = of_shapes(plain, [plain.shape | {'travel': 1e-3}], model, residual)
    (free,) = released(own, model, residual, True)
    assert figures(free) == {'stribeck_velocity', 'exponent', 'velocity_range', 'travel',
                             'plastic'}
    assert released(free, model, residual, True) == []


def test_another_way_of_turning_is_asked_with_its_own_travel(turned):
    model, residual, blocks, plain = turned
    shape = finer(plain, blocks, model, residual, ()).parts[0][0].shape
    assert shape['presliding_distance'] == pytest.approx(TRAVEL, rel=0.02)
    assert shape['plastic'] == pytest.approx(PLASTIC, rel=0.05)


def test_what_is_searched_again_is_judged_where_it_turns(turned):
    """Nothing else was found: all that could move the shape is another judge of it."""
    model, residual, blocks, plain = turned
    found = finer(plain, blocks, model, residual, ())
    again = searched_again(found, blocks, model, residual, ()).parts[0][0].shape
    assert again == pytest.approx(found.parts[0][0].shape, rel=1e-3)
