"""Candidates: which gain is sure, and which rivals cannot be told from the best."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hand_load_estimator.residual.measured.blocks import Score
from hand_load_estimator.residual.tracing.candidate import (Candidate, joined, significant, single,
                                                            standard_error, Step)
from hand_load_estimator.residual.tracing.choice import chosen_step
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.trace import Trace


@pytest.mark.parametrize('gains, sure', [
    ([50.0] * 4, True), ([50.0] * 3, False), ([20.0] * 4, False),
    ([200.0] * 6 + [-20.0] * 3, False), ([20.0, 200.0] * 4 + [-5.0], True),
    ([400.0] * 3 + [-2.0], True), ([400.0] * 2, False), ([4000.0, 30.0, 30.0], False)])
def test_what_gains_wherever_it_acts_is_sure(gains, sure):
    """Rare but steady: crossings of a gap in a few of 60 blocks; chance loses as often."""
    by_block = np.zeros(60)
    by_block[:len(gains)] = gains
    std = float(np.sqrt(60) * by_block.std())
    assert significant(Candidate('backlash', (), float(by_block.sum()), 10.0 * std,
                                 by_block)) is sure


def candidate(name, gain, spread=0.0):
    """Return a Candidate of joint 0: nats of gain in ten blocks, by turns so much more or less."""
    hypothesis = Hypothesis(name, 0, {0: np.ones((4, 1))}, np.ones(1))
    by_block = gain / 10.0 + spread * np.array([1.0, -1.0] * 5)
    return Candidate(name, ((hypothesis, None),), gain, standard_error(by_block), by_block)


@pytest.mark.parametrize('gain, rival', [(5.0, 'viscous_friction'), (-5.0, None)])
def test_what_gains_nothing_is_no_rival(gain, rival):
    best, other = candidate('rotor_inertia', 900.0), candidate('viscous_friction', gain)
    step = chosen_step(best, [best, other], 30.0, ())
    assert step.chosen is best and step.alternatives == ()
    assert (step.next_best and step.next_best.name) == rival


def test_without_an_adequate_rival_the_best_of_all_others_is_the_runner_up():
    best, other = candidate('rotor_inertia', 900.0), candidate('viscous_friction', 700.0)
    less = candidate('torque_offset', 30.0)
    step = chosen_step(best, [best], 30.0, [best, less, other])
    assert step.alternatives == () and step.next_best is other
    assert chosen_step(best, [best, less], 30.0, [other]).next_best is less


@pytest.mark.parametrize('behind, common', [(1.0, True), (80.0, False)])
def test_joints_that_agree_have_one_figure_in_common(behind, common):
    """Twelve figures that gain no more than two say less of the cause than the two."""
    def delays(gain, shared):
        parts = tuple((Hypothesis('time_delay', j, {j: np.ones((4, 1))}, np.ones(1),
                                  {'shift': 0.01}), None) for j in range(4))
        by_block = gain / 10.0 + shared * np.array([9.0, -9.0] * 5)
        return Candidate('time_delay', parts, gain, standard_error(by_block), by_block, shared)
    each, together = delays(2000.0, False), delays(2000.0 - behind, True)
    step = chosen_step(each, [each, together, candidate('viscous_friction', 90.0)], 30.0, ())
    assert step.chosen.common is common and step.next_best.name == 'viscous_friction'
    assert step.alternatives == ()


@pytest.mark.parametrize('other', ['cable_drag', 'rotor_inertia'])
@pytest.mark.parametrize('gain, spread, told', [
    (1900.0, 5.0, True), (1900.0, 20.0, False), (840.0, 20.0, True), (1990.0, 0.0, True)])
def test_an_alternative_is_what_blocks_cannot_tell(other, gain, spread, told):
    """What falls behind in every block is told, however little; not of a pair of the design."""
    best = candidate('gravity_spring', 2000.0)
    rival = candidate(other, gain, spread)
    step = chosen_step(best, [best, rival], 30.0, ())
    told = told and not (other == 'cable_drag' and gain == 1990.0)
    assert step.chosen is best and step.alternatives == (() if told else (rival,))


@pytest.mark.parametrize('name, other', [('gravity_spring', 'link_inertia'),
                                         ('torque_offset', 'friction_asymmetry')])
def test_of_pairs_named_together_only_those_of_one_joint_are(name, other):
    best, rival = candidate(name, 2000.0), candidate(other, 1990.0)
    elsewhere = Candidate(rival.name, tuple((replace(h, joint=1), s) for h, s in rival.parts),
                          rival.gain, rival.std, rival.by_block)
    step = chosen_step(best, [best, rival, elsewhere], 30.0, ())
    assert step.alternatives == (rival,)


def test_what_gains_no_more_than_chance_is_no_alternative():
    best, rival = candidate('gravity_spring', 200.0, -12.0), candidate('cable_drag', 130.0, 12.0)
    weak = candidate('torque_offset', 60.0, 40.0)
    step = chosen_step(best, [best, rival, weak], 30.0, ())
    assert step.alternatives == (rival,)


def test_a_joint_that_was_taken_along_and_shows_nothing_beside_the_others_is_left_out():
    gains = {0: 90.0, 1: 2.0, 2: 80.0}

    def parts(found):
        return tuple((Hypothesis('torque_scale', j, {j: np.ones((4, 1))}, np.ones(1)),
                      Score(gain, 1.0, np.full(10, gain / 10.0), np.ones(1), np.eye(1), {j: gain}))
                     for j, gain in found.items())
    chosen = joined('torque_scale', parts({0: 100.0, 1: 50.0, 2: 90.0}))
    again = joined('torque_scale', parts(gains))
    trace = SimpleNamespace(_gains=lambda score: score.gain > 8.0, _weighs=lambda candidate: True)
    step = Step(chosen, (), None, 30.0)
    kept = Trace._where_it_shows(trace, step, again)
    assert kept.chosen.joints == [0, 2] and kept.chosen.gain == pytest.approx(190.0)
    gains[1] = 40.0
    assert Trace._where_it_shows(trace, step, joined('torque_scale', parts(gains))) is step


@pytest.mark.parametrize('rival, joints', [(200.0, [0, 1]), (900.0, [0])])
def test_one_cause_of_many_joints_is_none_where_another_is_surely_better(rival, joints):
    """However much all of them gain together."""
    def pair(name, joint, gain):
        return (Hypothesis(name, joint, {joint: np.ones((4, 1))}, np.ones(1)),
                Score(gain, 1.0, np.full(10, gain / 10.0), np.ones(1), np.eye(1), {joint: gain}))
    trace = SimpleNamespace(_strong=lambda *_: True, _taken=set())
    scales = [pair('torque_scale', j, gain) for j, gain in ((0, 500.0), (1, 400.0))]
    (found,) = Trace._of_the_arm(trace, scales, [single(*pair('coulomb_friction', 1, rival))])
    assert found.joints == joints
    (alone,) = Trace._of_the_arm(trace, scales[1:], [single(*pair('cable_drag', 0, 900.0))])
    assert alone.joints == [1]
