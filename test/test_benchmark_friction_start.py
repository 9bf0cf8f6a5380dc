"""Friction's start in a case: of the same run, sample by sample, and gone once joints slide."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases
from hand_load_estimator.benchmark.friction_start import case_run_and_start

HIDDEN = ({'name': 'coulomb_friction', 'parameters': {'torque': 2.0}},)


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    """Let a case last three seconds."""
    monkeypatch.setattr(cases, 'DURATION', 3.0)


def drawn():
    return cases.draw_case(four_axes(), seeds.DEVELOPMENT_PLANTS[90],
                           seeds.DEVELOPMENT_CASES[995])


@pytest.mark.parametrize('hidden', [(), HIDDEN], ids=['clean', 'hidden'])
def test_the_run_is_the_cases_own(hidden):
    robot, case = four_axes(), replace(drawn(), hidden=hidden)
    run, friction = case_run_and_start(robot, case)
    own = cases.case_run(robot, case)
    assert run.start == own.start and len(run.samples) == len(own.samples) == len(friction.left)
    for one, other in zip(run.samples, own.samples):
        np.testing.assert_array_equal(one.effort, other.effort)
        np.testing.assert_array_equal(one.q, other.q)


def test_all_of_the_start_is_left_at_rest_and_nothing_of_it_in_the_end():
    run, friction = case_run_and_start(four_axes(), drawn())
    stamps = np.array([sample.stamp for sample in run.samples])
    q = np.array([sample.q for sample in run.samples])
    np.testing.assert_allclose(friction.left[stamps < 0.45], 1.0, atol=1e-3)
    gone = np.abs(q - q[0]) > 0.05
    assert gone[-1].sum() >= 3 and (np.abs(friction.left[gone]) < 0.02).all()


def test_a_hidden_effect_on_friction_counts():
    """What Coulomb friction came to the joints, they can hold at the start too."""
    clean, more = (case_run_and_start(four_axes(), replace(drawn(), hidden=hidden))[1]
                   for hidden in ((), HIDDEN))
    assert (more.std > clean.std + 0.5).all()
