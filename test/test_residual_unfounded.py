"""What the model written holds with figures of no such effect is only suspected, with a reason."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded, ripple, viscous

from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.effects.effect import SLOWEST
from hand_load_estimator.effects.presliding_hysteresis import LONGEST
from hand_load_estimator.effects.shear_thinning_friction import FASTEST
from hand_load_estimator.effects.stribeck_friction import FASTEST_PEAK
from hand_load_estimator.residual.add import better_model
from hand_load_estimator.residual.diagnosis import (CONFIRMED, Evidence, Finding,
                                                     SUSPECTED, UNKNOWN)
from hand_load_estimator.residual.doubts.unfounded import (EXACT, faint_in, of_another_kind,
                                                           small_beside_others, unsure_in,
                                                           without_unsure)
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis, looks_like_another
from hand_load_estimator.residual.tracing.trace import Trace

JOINTS = declared_model().robot.joints
EVIDENCE = Evidence(100.0, 10.0, 30.0, 12, 900, 1.0)
INTERVAL = 0.002


def finding(name, parameters, joints=JOINTS[1:2], **keywords):
    return Finding(name, tuple(joints), parameters, np.eye(4)[1], EVIDENCE, (), '', False,
                   CONFIRMED, **keywords)


@pytest.mark.parametrize('share, std, whole', [
    (1.02, 0.01, True), (0.7, 0.02, True), (2.46, 1.24, True), (0.33, 0.05, False),
    (0.33, 0.4, True), (0.55, 0.2, True), (1.6, 0.1, False)])
def test_a_share_of_a_delay_is_no_delay(share, std, whole):
    given = finding('time_delay', {'share': (share, std, '-'), 'delay': (0.01, 1e-3, 's')})
    (found,), told = of_another_kind((given,), INTERVAL)
    assert found.verdict == (CONFIRMED if whole else SUSPECTED)
    assert [text.split(':')[0] for text in told] == [JOINTS[1]] * (not whole)


def test_a_share_counts_at_every_joint():
    given = finding('time_delay', {f'share ({JOINTS[0]})': (1.0, 0.01, '-'),
                                   f'share ({JOINTS[1]})': (0.2, 0.01, '-')}, JOINTS[:2])
    (found,), (told,) = of_another_kind((given,), INTERVAL)
    assert found.verdict == SUSPECTED
    assert told == (f'{JOINTS[0]}, {JOINTS[1]}: time_delay is only suspected: all of the torque '
                    'would come late, but the model written delays 0.2 ± 0.02 of it (two '
                    'standard deviations)')


@pytest.mark.parametrize('delay, joints, sure', [
    (0.45 * INTERVAL, 1, False), (0.55 * INTERVAL, 1, True), (0.45 * INTERVAL, 4, True)])
def test_a_short_delay_of_one_joint_is_only_suspected(delay, joints, sure):
    given = finding('time_delay', {'share': (1.0, 0.01, '-'), 'delay': (delay, 1e-5, 's')},
                    JOINTS[:joints])
    (found,), told = of_another_kind((given,), INTERVAL)
    assert found.verdict == (CONFIRMED if sure else SUSPECTED)
    assert told == () if sure else told == (
        f'{JOINTS[0]}: time_delay is only suspected: 0.9 ms is less than half of the 2 ms '
        'between two joint states, too short to be told from what other effects leave',)


@pytest.mark.parametrize('near', [1.0, 1.03])
@pytest.mark.parametrize('name, shape', [('stribeck_friction', 'stribeck_velocity'),
                                         ('shear_thinning_friction', 'thinning_velocity')])
def test_a_peak_below_all_motion_is_known_by_its_tail_only(name, shape, near):
    """A search stops a little before the end of a shape."""
    seen, below = (finding(name, {'level': (6.0, 0.1, 'Nm'), shape: (velocity, 1e-3, 'rad/s')})
                   for velocity in (1.2 * SLOWEST, near * SLOWEST))
    found, (told,) = of_another_kind((seen, below), INTERVAL)
    assert [f.verdict for f in found] == [CONFIRMED, SUSPECTED]
    assert told.startswith(f'{JOINTS[1]}: {name} is only suspected: its {shape} is at or below')
    # No search goes further.
    narrow = EFFECTS[name].bounded({shape: 0.1 * SLOWEST, 'exponent': 1.0})
    assert narrow == {shape: SLOWEST, 'exponent': 1.0}


@pytest.mark.parametrize('name, shape, most', [
    ('stribeck_friction', 'stribeck_velocity', FASTEST_PEAK),
    ('shear_thinning_friction', 'thinning_velocity', FASTEST),
    ('presliding_hysteresis', 'presliding_distance', LONGEST)])
def test_what_reaches_the_end_of_its_range_may_be_another_effect(name, shape, most):
    seen, at_end = (finding(name, {'level': (6.0, 0.1, 'Nm'), shape: (value, 0.1, 'rad')})
                    for value in (0.8 * most, most))
    found, (told,) = of_another_kind((seen, at_end), INTERVAL)
    assert [f.verdict for f in found] == [CONFIRMED, SUSPECTED]
    assert told.startswith(f'{JOINTS[1]}: {name} is only suspected: its {shape} is at or above')
    assert EFFECTS[name].bounded({shape: 2.0 * most}) == {shape: most}


@pytest.mark.parametrize('share, faint', [(0.01, True), (1.0, False), (-1.0, False)])
def test_what_is_nothing_beside_everything_else_is_only_suspected(traced, share, faint):
    model, trace, change = traced
    mean = model.mean.copy()
    mean[place(model)] += share * change
    found = faint_in(model, replace(model, mean=mean), trace)
    assert found == ({('viscous_friction', JOINTS[1:2])} if faint else set())
    given = finding('viscous_friction', {'coefficient': (1.0, 0.1, 'Nm s/rad')})
    (said,), told = of_another_kind((given,), INTERVAL, found)
    assert said.verdict == (SUSPECTED if faint else CONFIRMED)
    assert [text.partition(' is only')[0] for text in told] == [
        f'{JOINTS[1]}: viscous_friction'] * faint


def place(model, name='viscous_friction'):
    return next(where for use, where in model.slices()
                if (use.name, use.joint) == (name, 1))


@pytest.fixture(scope='module')
def traced():
    """Return the model, a Trace that found viscous friction, and how much of it [Nm s/rad]."""
    model = declared_model()
    residual = find_residual(model, recorded(on(1, 4.0, viscous)))
    trace = Trace(model, residual, ())
    (step,) = trace.run()
    (hypothesis, score), = step.chosen.parts
    return model, trace, float(score.theta[0] * hypothesis.scale[0])


def test_a_new_effect_with_a_shape_is_nothing_where_its_figures_are():
    model, evidence = declared_model(), recorded(on(1, 4.0, ripple))
    trace = Trace(model, find_residual(model, evidence), ())
    better = better_model(model, trace.run(), evidence)
    assert faint_in(model, better, trace) == set()
    mean = better.mean.copy()
    mean[next(where for use, where in better.slices() if use.name == 'torque_ripple')] = 0.0
    assert faint_in(model, replace(better, mean=mean), trace) == {('torque_ripple', JOINTS[1:2])}


def gaining(name, by_joint, **keywords):
    """Return a confirmed Finding that gains {joint index: nats}; needed are 30."""
    found = finding(name, {}, [JOINTS[j] for j in by_joint], **keywords)
    return replace(found, evidence=replace(
        EVIDENCE, gain=sum(by_joint.values()),
        by_joint={JOINTS[j]: gain for j, gain in by_joint.items()}))


@pytest.mark.parametrize('share, joint, sure', [
    (0.9 * EXACT ** 2, 1, False), (1.1 * EXACT ** 2, 1, True), (0.9 * EXACT ** 2, 2, True)])
def test_what_is_small_beside_another_at_its_joint_may_be_its_rest(share, joint, sure):
    large = gaining('time_delay', {1: 1e5})
    small = gaining('stribeck_friction', {joint: share * 1e5})
    found, told = small_beside_others((large, small))
    assert found[0] is large and found[1].verdict == (CONFIRMED if sure else SUSPECTED)
    assert told == () if sure else told[0].startswith(
        f'{JOINTS[1]}: stribeck_friction is only suspected: what it explains at {JOINTS[1]} is '
        'less than 5 % of the torque of time_delay there')


@pytest.mark.parametrize('here, sure', [(1e5, False), (1e3, True)])
def test_a_cause_of_all_joints_is_large_where_it_gains(here, sure):
    everywhere = gaining('base_tilt', {0: 1e6, 1: here, 2: 0.0, 3: 10.0})
    small = gaining('cable_drag', {1: 200.0})
    found, _ = small_beside_others((small, everywhere))
    assert [f.verdict for f in found] == [CONFIRMED if sure else SUSPECTED, CONFIRMED]


@pytest.mark.parametrize('elsewhere, sure', [(31.0, True), (29.0, False)])
def test_a_cause_of_more_joints_stands_where_another_joint_shows_it(elsewhere, sure):
    several = gaining('torque_scale', {1: 100.0, 2: elsewhere})
    large = gaining('coulomb_friction', {1: 1e6})
    found, told = small_beside_others((several, large))
    assert found[0].verdict == (CONFIRMED if sure else SUSPECTED)
    assert told == () if sure else told[0].startswith(
        f'{JOINTS[1]}, {JOINTS[2]}: torque_scale is only suspected')


def test_a_loss_at_a_joint_where_nothing_else_is_makes_nothing_small():
    several = gaining('base_tilt', {0: 29.9, 1: -3.0, 2: -0.01})
    other = gaining('cable_drag', {2: 1e3, 3: 1e6})
    assert small_beside_others((several, other)) == ((several, other), ())


def test_what_has_no_formula_leaves_no_rest():
    large, small = gaining(UNKNOWN, {1: 1e6}), gaining('stribeck_friction', {1: 100.0})
    assert small_beside_others((large, small)) == ((large, small), ())


@pytest.mark.parametrize('small', [0, 1])
def test_what_happened_once_leaves_no_rest_and_is_none(small):
    once = replace(finding('external_contact', {}, recording='one'),
                   evidence=replace(EVIDENCE, gain=1e6 if small else 1.0))
    lasting = gaining('stribeck_friction', {1: 100.0 if small else 1e6})
    assert small_beside_others((once, lasting)) == ((once, lasting), ())


@pytest.mark.parametrize('name', sorted(EFFECTS))
def test_no_effect_stands_at_the_end_of_its_shape_as_it_is_declared(name):
    effect = EFFECTS[name]
    plain = Hypothesis(name, 0, {}, np.ones(len(effect.parameters)), effect.default_shape())
    assert not looks_like_another(plain)
    for shape in effect.shapes:
        if np.isfinite(shape.most):
            near = 0.99 * shape.most
            ended = replace(plain, shape={**plain.shape, shape.name: near})
            # Where all yields is where the plainest contacts are.
            assert looks_like_another(ended) == (shape.name != 'plastic')


def test_what_is_only_suspected_makes_nothing_small():
    large = replace(gaining('time_delay', {1: 1e5}), verdict=SUSPECTED)
    small = gaining('stribeck_friction', {1: 100.0})
    assert small_beside_others((large, small)) == ((large, small), ())


@pytest.mark.parametrize('share, beside, alike, sure', [
    (1.0, '', 0.0, True), (0.25, '', 0.0, True), (0.15, '', 0.0, False),
    (0.08, 'coulomb_friction', 0.99, True), (0.12, 'coulomb_friction', 0.0, False),
    (0.25, 'coulomb_friction', 0.0, True), (0.08, 'time_delay', 0.99, False)])
def test_figures_within_chance_of_nothing_are_unsure(traced, share, beside, alike, sure):
    """
    Both figures changed by so many times ten of their own deviations.

    alike: how far the data tell only the sum of both; what is beside counts if it looks like it.
    """
    model, trace, _ = traced
    own, other = (place(model, name) for name in ('viscous_friction', 'coulomb_friction'))
    mean, covariance = model.mean.copy(), model.covariance.copy()
    covariance[own, own] = covariance[other, other] = 1.0
    covariance[own, other] = covariance[other, own] = -alike
    mean[own] += 10.0 * share
    mean[other] += 10.0 * share if alike else 0.0
    key = 'viscous_friction', JOINTS[1:2]
    (step,) = trace.steps
    rival = replace(step.chosen, name=beside)
    trace = SimpleNamespace(steps=[replace(step, alternatives=(rival,) if beside else ())])
    unsure = unsure_in(model, replace(model, mean=mean, covariance=covariance), trace)
    assert unsure == {key: () if sure else JOINTS[1:2]}
    (found,), told = without_unsure((finding(*key[:1], {}),), unsure)
    assert found.verdict == (CONFIRMED if sure else SUSPECTED) and bool(told) != sure


def test_joints_where_an_effect_is_nothing_are_left_out_of_it():
    own, other = JOINTS[1], JOINTS[2]
    given = finding('torque_scale', {f'gain ({own})': (0.1, 0.01, '-'),
                                     f'gain ({other})': (1e-4, 0.02, '-')}, (own, other))
    (found,), (told,) = without_unsure((given,), {('torque_scale', (own, other)): (other,)})
    assert found.joints == (own,) and found.verdict == CONFIRMED
    assert list(found.parameters) == [f'gain ({own})']
    assert told.startswith(f'{other}: no torque_scale is told there')


def test_a_joint_that_is_left_out_is_not_the_one_that_shows_it_most():
    own, other = JOINTS[1], JOINTS[2]
    given = gaining('torque_scale', {1: 100.0, 2: 200.0})
    assert given.main_joint(JOINTS) == 2
    (found,), _ = without_unsure((given,), {('torque_scale', (own, other)): (other,)})
    assert found.main_joint(JOINTS) == 1 and found.evidence.gain == 100.0
