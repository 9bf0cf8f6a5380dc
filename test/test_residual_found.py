"""What a trace found, each beside all the rest: delays delay all of it, as long as they stand."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import constant_friction, declared_model, on, recorded, ripple
from test_residual_declared_delay import delaying
from test_residual_delay_among_others import DELAY, JOINT, late_with

from hand_load_estimator.effects import EFFECTS, LATE
from hand_load_estimator.effects.stribeck_friction import FASTEST_PEAK
from hand_load_estimator.identification.regression_system import System
from hand_load_estimator.residual.diagnosis import UNKNOWN
from hand_load_estimator.residual.measured.find import find_residual, use_of
from hand_load_estimator.residual.tracing import together as together_module
from hand_load_estimator.residual.tracing.candidate import single, Step
from hand_load_estimator.residual.tracing.finer_shape import best_of_each
from hand_load_estimator.residual.tracing.found import Found
from hand_load_estimator.residual.tracing.hypotheses import hypotheses, of_shapes
from hand_load_estimator.residual.tracing.together import Together
from hand_load_estimator.residual.tracing.trace import Trace

NEEDED = 30.0


def candidates(model, residual, shapes):
    """Return {name: Candidate} of joint JOINT alone, with the shapes {name: shape}."""
    blocks, found = residual.blocks(), {}
    for hypothesis in hypotheses(model, residual, blocks, ()):
        name = hypothesis.name
        if hypothesis.joint != JOINT or name not in shapes or name in found:
            continue
        if shapes[name]:
            whole = EFFECTS[name].default_shape() | shapes[name]
            (hypothesis,) = of_shapes(hypothesis, [whole], model, residual)
        found[name] = single(hypothesis, blocks.evaluate(hypothesis.columns))
    return found


def step(candidate, *alternatives):
    return Step(candidate, alternatives, None, NEEDED)


@pytest.fixture(scope='module')
def late_ripple():
    """Return model, Residual and Candidates of a ripple whose joint reports its torque late."""
    model = declared_model()
    residual = find_residual(model, recorded(late_with(ripple, 6.0))[:-1])
    return model, residual, candidates(model, residual, {
        LATE: {'shift': 0.7 * DELAY}, 'torque_ripple': {'periods': 23.4}, 'viscous_friction': {}})


def found_in(late_ripple):
    """Return Found with the ripple and its delay, settled."""
    model, residual, those = late_ripple
    found = Found(model, residual, (), None, lambda candidate: True)
    for name in ('torque_ripple', LATE):
        found.add(step(those[name]))
    assert found.settle() == {JOINT}
    return found


def test_a_delay_settles_with_what_it_delays(late_ripple):
    found = found_in(late_ripple)
    (rippled, _), = found.steps[0].chosen.parts
    (delay, _), = found.steps[1].chosen.parts
    assert delay.shape['shift'] == pytest.approx(DELAY, rel=0.1)
    assert found.residual.delays == {JOINT: delay.shape['shift']}
    assert rippled.shape['periods'] == pytest.approx(23.4, abs=0.05)
    np.testing.assert_array_equal(rippled.columns[JOINT],
                                  found.residual.reported(rippled.prompt)[JOINT])


def test_what_a_delay_delayed_comes_at_once_without_it(late_ripple):
    found = found_in(late_ripple)
    rippled, delay = found.steps
    found.drop(delay)
    assert found.residual.delays == {} and len(found.steps) == 1
    (before, _), (after, _) = rippled.chosen.parts[0], found.steps[0].chosen.parts[0]
    assert np.abs(before.columns[JOINT] - before.prompt[JOINT]).max() > 0.1
    np.testing.assert_array_equal(after.columns[JOINT], before.prompt[JOINT])


def test_a_delay_is_worth_what_is_lost_without_it(late_ripple):
    """What it delayed comes at once then."""
    found = found_in(late_ripple)
    rippled, delay = found.steps
    before, (value, own) = found.blocks().misfit(JOINT), (
        found.evidence(step) for step in (delay, rippled))
    assert own.gain == pytest.approx(single(
        own.parts[0][0], found.beside(rippled).evaluate(own.columns)).gain)
    found.drop(delay)
    lost = found.blocks().misfit(JOINT) - before
    np.testing.assert_allclose(value.by_block, lost, rtol=1e-6, atol=1e-6)
    (_, score), = value.parts
    assert value.gain == pytest.approx(lost.sum()) == score.by_joint[JOINT] > 1000.0


@pytest.mark.parametrize('expected, joints', [(False, {JOINT}), (True, set())])
def test_what_is_as_expected_is_not_searched_again(late_ripple, expected, joints):
    model, residual, those = late_ripple
    found = Found(model, residual, (), None, lambda candidate: True)
    found.add(replace(step(those['viscous_friction']), expected=expected))
    found.add(step(those['torque_ripple']))
    assert found.settle() == joints
    assert [len(found.steps), len(found.drifted)] == ([1, 1] if expected else [2, 0])


def test_what_takes_a_place_is_possible_and_matters(late_ripple):
    model, residual, those = late_ripple
    trace = Trace(model, residual, ())
    (delay, score), = those[LATE].parts
    for share, possible in ((1.0, True), (-1.0, False), (0.3, False)):
        fitted = replace(score, theta=np.array([share]) / delay.scale,
                         covariance=np.array([[1e-4]]) / delay.scale ** 2)
        assert trace._possible(single(delay, fitted)) == possible
    (friction, score), = those['viscous_friction'].parts
    for size, possible in ((1e-4, False), (1.0, True)):
        assert trace._possible(single(friction, replace(score, theta=np.array([size])))) \
            == possible


def test_a_delay_of_another_size_in_its_place_delays_all(late_ripple):
    model, residual, _ = late_ripple
    found = found_in(late_ripple)
    other = candidates(model, residual, {LATE: {'shift': 0.02}})[LATE]
    found.put(step(other), found.steps[1])
    assert found.residual.delays == {JOINT: 0.02}
    (rippled, _), = found.steps[0].chosen.parts
    np.testing.assert_array_equal(rippled.columns[JOINT],
                                  found.residual.reported(rippled.prompt)[JOINT])


def test_a_backward_check_that_drops_a_delay_leaves_nothing_late(late_ripple):
    model, residual, those = late_ripple
    trace = Trace(model, residual, ())
    trace.run()
    assert {s.chosen.name for s in trace.steps} == {'torque_ripple', LATE}
    for found in list(trace.steps):
        if found.chosen.name == LATE:
            trace._found.put(Step(found.chosen, (), None, np.inf), found)
    trace.keep_what_still_gains()
    assert [s.chosen.name for s in trace.steps] == ['torque_ripple']
    assert trace.residual.delays == {}
    (rippled, _), = trace.steps[0].chosen.parts
    np.testing.assert_array_equal(rippled.columns[JOINT], rippled.prompt[JOINT])


def test_a_delay_is_tried_beside_what_was_chosen():
    """Beside a large ripple with the phase of what comes late other effects look better."""
    model = declared_model()
    residual = find_residual(model, recorded(late_with(ripple, 30.0))[:-1])
    blocks = residual.blocks()
    found, _ = best_of_each(hypotheses(model, residual, blocks, ()), blocks)
    singles = [single(*found[key]) for key in found if key[1] == JOINT and key[0] != UNKNOWN]
    chosen = max(singles, key=lambda c: c.gain)
    assert chosen.name == 'torque_ripple'
    together = Together(model, residual, (), blocks, JOINT, set(), singles, lambda *pair: True)
    steps = together.instead_of(chosen, NEEDED, lambda candidate: True)
    assert {s.chosen.name for s in steps} == {'torque_ripple', LATE}
    delay = next(s.chosen for s in steps if s.chosen.name == LATE)
    assert delay.parts[0][0].shape['shift'] == pytest.approx(DELAY, rel=0.05)


def test_a_delay_is_none_beside_a_simpler_cause_that_makes_it_impossible(monkeypatch):
    model = declared_model()
    residual = find_residual(model, recorded(late_with(ripple, 30.0))[:-1])
    blocks = residual.blocks()
    found, _ = best_of_each(hypotheses(model, residual, blocks, ()), blocks)
    singles = [single(*found[key]) for key in found if key[1] == JOINT and key[0] != UNKNOWN]
    chosen = max(singles, key=lambda c: c.gain)
    swapped = []
    whole = together_module._step

    def with_a_note(*given):
        swapped.append(whole(*given))
        return swapped[-1]
    monkeypatch.setattr(together_module, '_step', with_a_note)
    together = Together(model, residual, (), blocks, JOINT, set(), singles,
                        lambda hypothesis, score: not swapped or hypothesis.name != LATE)
    assert LATE not in {s.chosen.name for s in together.instead_of(
        chosen, NEEDED, lambda candidate: True)}
    assert swapped


@pytest.mark.parametrize('possible, name', [(True, 'coulomb_friction'),
                                            (False, 'stribeck_friction')])
def test_what_stands_at_its_end_gives_way_to_what_it_looks_like_if_that_may_be(possible, name):
    """A peak that has not fallen at the fastest motion is a level, were it not impossible."""
    model = declared_model()
    residual = find_residual(model, recorded(on(JOINT, 3.0, ripple),
                                             on(JOINT, 6.0, constant_friction))[:-1])
    those = candidates(model, residual, {
        'torque_ripple': {'periods': 23.4}, 'coulomb_friction': {},
        'stribeck_friction': {'stribeck_velocity': FASTEST_PEAK}})
    asked = []
    found = Found(model, residual, (), None, lambda c: asked.append(c.name) or possible)
    found.add(step(those['torque_ripple']))
    found.add(step(those['stribeck_friction'], those['coulomb_friction']))
    found.settle()
    assert asked == ['coulomb_friction']
    assert [s.chosen.name for s in found.steps] == ['torque_ripple', name]
    assert (('coulomb_friction', JOINT, '') in found.taken) == possible


def test_rivals_are_weighed_again_beside_what_was_found_since():
    """A level gained much while a ripple was in the residual; what was found is no rival."""
    model = declared_model()
    residual = find_residual(model, recorded(on(JOINT, 3.0, ripple),
                                             on(JOINT, 6.0, constant_friction))[:-1])
    those = candidates(model, residual, {'torque_ripple': {'periods': 23.4},
                                         'coulomb_friction': {}, 'viscous_friction': {}})
    overrated = replace(those['viscous_friction'], gain=1e9)
    found = Found(model, residual, (), None, lambda c: c.name != 'viscous_friction')
    found.add(replace(step(those['torque_ripple']), next_best=those['coulomb_friction']))
    found.add(replace(step(those['coulomb_friction']), next_best=overrated))
    found.settle()
    found.weigh_again()
    rippled, level = found.steps
    assert rippled.next_best is None and rippled.next_possible
    assert not level.next_possible
    assert level.next_best.name == 'viscous_friction' and level.alternatives == ()
    assert level.next_best.gain == pytest.approx(
        found.beside(level).evaluate(overrated.parts[0][0].columns).gain)
    # What was chosen is weighed on the same blocks: a ripple was in the residual when it was.
    assert level.chosen.gain == pytest.approx(found.evidence(level).gain)
    assert level.chosen.gain != pytest.approx(those['coulomb_friction'].gain, rel=1e-3)


def test_parameters_of_a_late_joint_are_fitted_again_as_late_as_it_is():
    """All but the delay's own, which says how late already."""
    model = delaying(1.0, 0.04)
    residual = find_residual(model, recorded()[:1])
    places = {(use.name, use.joint): where.start for use, where in model.slices()}
    for name, late in (('coulomb_friction', True), (LATE, False)):
        root = np.zeros((len(model.mean),) * 2)
        root[places[name, JOINT], places[name, JOINT]] = 1.0
        (fitted,) = residual.blocks(root).nuisances[JOINT].T
        own = residual.columns[:, JOINT, places[name, JOINT]]
        then = residual.reported({JOINT: own[:, None]})[JOINT][:, 0]
        assert np.abs(then - own).max() > 0.1
        wanted = then if late else own
        np.testing.assert_allclose(fitted * np.sign(fitted @ wanted), wanted, atol=1e-9)


def test_an_effect_that_is_reshaped_is_as_late_as_before():
    model = delaying(0.7, 0.04)
    system = System(model.robot, model.uses, recorded()[:2], model.mean)
    before = system.columns.copy()
    use, where = next(pair for pair in model.slices()
                      if (pair[0].name, pair[0].joint) == ('coulomb_friction', JOINT))
    system.columns[:, JOINT, where] = 0.0
    system.reshape(use_of(use.name, use.joint, use.shape), where)
    np.testing.assert_allclose(system.columns, before, atol=1e-12)
