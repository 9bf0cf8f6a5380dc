"""The better model: what is known stays, what is new or changed is estimated."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import cable, declared_model, noise_of, on, recorded, ripple, viscous
from test_known_recordings import on_disk

from hand_load_estimator.residual.add import better_model, WIDER
from hand_load_estimator.residual.diagnose import errors_of
from hand_load_estimator.residual.tracing.hypotheses import with_effect
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.torque.columns import effect_slices


def step_of(name, joint, shape=None, alternatives=()):
    """Return a Step that says an effect was found."""
    hypothesis = Hypothesis(name, joint, {}, np.ones(1), shape or {})
    return SimpleNamespace(chosen=SimpleNamespace(parts=((hypothesis, None),), common=False),
                           alternatives=[SimpleNamespace(name=other, joints=[place])
                                         for other, place in alternatives])


def parameter(model, name, joint):
    """Return (mean, std) of the first parameter of an effect."""
    for use, where in model.slices():
        if (use.name, use.joint) == (name, joint):
            return model.mean[where.start], np.sqrt(model.covariance[where.start, where.start])
    return None


def wrong(factor=1.5, doubt=1e-4):
    """Return a model that is sure of a wrong Coulomb level of joint 0."""
    model = declared_model(doubt)
    mean = model.mean.copy()
    for use, where in model.slices():
        if (use.name, use.joint) == ('coulomb_friction', 0):
            mean[where] *= factor
    return replace(model, mean=mean)


def test_new_recordings_leave_what_is_known_and_fill_in_what_is_new():
    """The old model is the prior: sure of a Coulomb level it keeps it, the ripple is estimated."""
    model, evidence = wrong(), recorded(on(2, 2.0, ripple))
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    old, std = parameter(model, 'coulomb_friction', 0)
    new, after = parameter(found, 'coulomb_friction', 0)
    assert abs(new - old) < 4.0 * WIDER * std and after <= WIDER * std * 1.001
    size = 2.0 * np.sqrt(2.0) * noise_of(model.robot)[2]
    mean, std = parameter(found, 'torque_ripple', 2)
    assert mean == pytest.approx(size * np.cos(0.5), abs=4.0 * std + 0.02 * size)
    assert parameter(found, 'torque_ripple', 1) is None
    assert found.recording_names == [*model.recording_names, 'run 0', 'run 1', 'run 2', 'run 3']


def test_what_was_found_changed_is_free_again():
    model, evidence = wrong(), recorded()
    found = better_model(model, [step_of('coulomb_friction', 0)], evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert abs(mean - truth) < 4.0 * std + 0.01 * truth and std < 0.05 * truth


@pytest.mark.parametrize('alternatives, free', [
    ((), False), ((('coulomb_friction', 0),), True), ((('coulomb_friction', 1),), False),
    ((('rotor_inertia', 0),), False)])
def test_what_may_have_changed_instead_is_free_too(alternatives, free):
    """Nothing told friction of a loaded gear from Coulomb's: the fit of everything may."""
    model, evidence = wrong(), recorded()
    found = better_model(model, [step_of('load_dependent_friction', 0, None, alternatives)],
                         evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert (abs(mean - truth) < 4.0 * std + 0.02 * truth) == free


def test_its_own_recordings_are_not_counted_twice():
    """From the recordings it was made of, all is estimated anew, with the robot file's prior."""
    evidence = on_disk(recorded(on(2, 2.0, ripple)))
    model = replace(wrong(), recordings=tuple(e.mark for e in evidence))
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    truth, _ = parameter(declared_model(), 'coulomb_friction', 0)
    mean, std = parameter(found, 'coulomb_friction', 0)
    assert abs(mean - truth) < 5.0 * std + 0.02 * truth
    assert std > 3.0 * parameter(model, 'coulomb_friction', 0)[1]
    assert found.recordings == model.recordings


@pytest.mark.parametrize('joint, effect, name, shape', [
    (2, ripple, 'torque_ripple', {'periods': 23.4}), (1, cable, 'cable_drag', {}),
    (3, viscous, 'viscous_friction', {})])
def test_the_better_model_is_better_on_what_it_has_not_seen(joint, effect, name, shape):
    model, evidence = declared_model(), recorded(on(joint, 2.0, effect))
    found = better_model(model, [step_of(name, joint, shape)], evidence[:3])
    before, after = (np.sqrt(np.nanmean(errors_of(m, evidence[3:]) ** 2, axis=0))
                     for m in (model, found))
    noise = noise_of(model.robot)
    assert after[joint] < 1.15 * noise[joint] < 0.8 * before[joint]
    assert (after < 1.02 * before).all() and (found.noise < 1.15 * noise).all()


def test_links_that_were_never_identified_are_not_said_to_be():
    model, evidence = declared_model(), recorded(on(2, 2.0, ripple))
    assert not model.links_declared
    found = better_model(model, [step_of('torque_ripple', 2, {'periods': 23.4})], evidence)
    assert not found.links_declared
    np.testing.assert_array_equal(found.mean[:40], model.mean[:40])


def test_presliding_enters_a_model_that_had_none():
    """A model of plain friction that turns over a travel gets the effect, and is better for it."""
    names = ('rotor_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')
    model = declared_model(0.01, names)
    hypothesis = step_of('presliding_hysteresis', 1,
                         {'presliding_distance': 2e-3}).chosen.parts[0][0]
    uses = with_effect(model.uses, hypothesis, {})
    assert [(u.joint, u.shape) for u in uses if u.name == 'presliding_hysteresis'] \
        == [(1, {'presliding_distance': 2e-3, 'plastic': 2.0})]
    # A model that has it keeps one, with the new travel.
    uses = with_effect(declared_model().uses, hypothesis, {})
    assert [u.shape['presliding_distance'] for u in uses if u.name == 'presliding_hysteresis'
            and u.joint == 1] == [2e-3]
    assert len(effect_slices(4, uses)) == len(declared_model().uses)
