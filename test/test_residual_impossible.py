"""A model whose friction drives the joint is told to be impossible, and confirms nothing there."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import declared_model, on, recorded, viscous

from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED, UNKNOWN
from hand_load_estimator.residual.doubts.impossible import impossible, on_wrong_footing
from hand_load_estimator.residual.measured.blocks import Score
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis, physical


def with_value(name, joint, value, std):
    """Return the model with another first parameter of an effect."""
    model = declared_model()
    where = next(w for u, w in model.slices() if (u.name, u.joint) == (name, joint))
    mean, covariance = model.mean.copy(), model.covariance.copy()
    mean[where.start] = value
    covariance[where.start, where.start] = std ** 2
    return replace(model, mean=mean, covariance=covariance)


def finding(name, joint, recording=''):
    explained = np.eye(4)[joint]
    return Finding(name, (declared_model().robot.joints[joint],), {}, explained,
                   Evidence(100.0, 10.0, 30.0, 12, 900, 1.0), (), '', False, CONFIRMED,
                   recording=recording)


@pytest.mark.parametrize('name', ['viscous_friction', 'coulomb_friction', 'rotor_inertia'])
def test_what_is_surely_below_zero_is_impossible(name):
    assert impossible(declared_model()) == ()
    assert impossible(with_value(name, 2, -0.7, 0.4)) == ()
    found, = impossible(with_value(name, 2, -0.7, 0.15))
    assert (found.joint, found.effect, found.mean, found.std) == (2, name, -0.7, 0.15)
    assert impossible(with_value('torque_offset', 2, -0.7, 0.15)) == ()


def test_the_report_names_joint_parameter_and_interval():
    joints = declared_model().robot.joints
    wrong = with_value('viscous_friction', 2, -0.52, 0.2)
    findings, told = on_wrong_footing((), joints, wrong, wrong)
    assert findings == () and told == (
        f'{joints[2]}: the model that was diagnosed is impossible at this joint: coefficient of '
        'viscous_friction -0.52 ± 0.4 Nm s/rad (two standard deviations), and physics allows '
        'none below zero',)
    _, told = on_wrong_footing((), joints, wrong, with_value('viscous_friction', 2, -0.72, 0.15))
    assert len(told) == 2 and told[1].startswith(f'{joints[2]}: the model written is impossible')


def test_what_stands_on_it_is_only_suspected():
    wrong = with_value('viscous_friction', 2, -0.72, 0.15)
    given = (finding('cable_drag', 2), finding('cable_drag', 1), finding(UNKNOWN, 2),
             finding('external_contact', 2, 'run 0'))
    findings, _ = on_wrong_footing(given, wrong.robot.joints, declared_model(), wrong)
    assert [f.verdict for f in findings] == [SUSPECTED, CONFIRMED, CONFIRMED, CONFIRMED]
    # What makes it possible again stands.
    findings, told = on_wrong_footing(given, wrong.robot.joints, wrong, declared_model())
    assert {f.verdict for f in findings} == {CONFIRMED} and len(told) == 1


@pytest.mark.parametrize('change, declared, allowed', [
    (-0.5, (1.0, 0.05), True), (-0.9, (1.0, 0.2), True), (-1.5, (1.0, 0.05), False),
    (-1.5, (1.0, 0.5), True), (0.3, (-0.7, 0.05), False), (0.3, None, True), (-0.3, None, False)])
def test_a_change_may_not_lead_below_zero(change, declared, allowed):
    hypothesis = Hypothesis('viscous_friction', 1, {1: np.ones((3, 1))}, np.array([2.0]))
    score = Score(50.0, 5.0, np.ones(12), np.array([change / 2.0]), np.array([[0.05 ** 2]]), {})
    declared = declared and tuple(np.array([value]) for value in declared)
    assert physical(hypothesis, score, declared) is allowed


@pytest.mark.parametrize('gain, declared, allowed', [
    (-0.6, None, True), (-0.9, None, False), (-2.0, None, False), (3.5, None, True),
    (5.0, None, False), (-0.5, 0.1, True), (-0.5, -0.4, False)])
def test_no_torque_constant_has_another_sign_or_is_off_by_five(gain, declared, allowed):
    hypothesis = Hypothesis('torque_scale', 1, {1: np.ones((3, 1))}, np.array([0.1]))
    score = Score(50.0, 5.0, np.ones(12), np.array([gain / 0.1]), np.array([[0.05 ** 2]]), {})
    declared = declared and (np.array([declared]), np.array([0.01]))
    assert physical(hypothesis, score, declared) is allowed


def test_less_friction_than_none_is_not_named():
    """The drive helps the motion by more than its friction was: no figure of friction."""
    model = declared_model()
    less = on(1, 1.0, viscous)
    level = next(model.mean[w][0] for u, w in model.slices()
                 if (u.name, u.joint) == ('viscous_friction', 1))

    def helping(run):
        out = less(run)
        out[:, 1] = -2.0 * level * run.x.v[:, 1]
        return out
    evidence = recorded(helping)
    diagnosis, _ = diagnose(model, evidence[:-1], evidence[-1:])
    assert not [f for f in diagnosis.findings
                if f.name == 'viscous_friction' and f.verdict == CONFIRMED]
    assert diagnosis.findings
