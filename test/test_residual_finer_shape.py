"""How friction turns is asked where it turns: with the travel that each way of turning wants."""

import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded

from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.candidate import single
from hand_load_estimator.residual.tracing.finer_shape import (best_of_each, finer, search_around,
                                                              searched_again)
from hand_load_estimator.residual.tracing.hypotheses import hypotheses
from hand_load_estimator.torque.presliding import presliding_path

NAME, JOINT = 'presliding_hysteresis', 1
TRAVEL, POWER = 6e-3, 2.0


def turning(run):
    """Friction that turns over a few encoder steps more than declared, and then is at its level."""
    way = np.full(run.robot.n, TRAVEL), np.full(run.robot.n, POWER)
    return presliding_path(run.motion.q, run.motion.v, run.motion.dt, *way)[0] - run.x.z


@pytest.fixture(scope='module')
def turned():
    """Return model, Residual, Blocks and the best Candidate of those that never quite turn."""
    model = declared_model()
    residual = find_residual(model, recorded(on(JOINT, 6.0, turning))[:-1])
    blocks = residual.blocks()
    never = [h for h in hypotheses(model, residual, blocks, ())
             if (h.name, h.joint) == (NAME, JOINT) and np.isinf(h.shape['power'])]
    (pair,), _ = best_of_each(never, blocks)[0].values(), None
    best, _ = search_around(pair, blocks, model, residual)
    return model, residual, blocks, single(*best)


def test_another_way_of_turning_is_asked_with_its_own_travel(turned):
    model, residual, blocks, plain = turned
    shape = finer(plain, blocks, model, residual, ()).parts[0][0].shape
    assert shape['presliding_distance'] == pytest.approx(TRAVEL, rel=0.02)
    assert shape['power'] == pytest.approx(POWER, rel=0.05)


def test_what_is_searched_again_is_judged_where_it_turns(turned):
    """Nothing else was found: all that could move the shape is another judge of it."""
    model, residual, blocks, plain = turned
    found = finer(plain, blocks, model, residual, ())
    again = searched_again(found, blocks, model, residual, ()).parts[0][0].shape
    assert again == pytest.approx(found.parts[0][0].shape, rel=1e-3)
