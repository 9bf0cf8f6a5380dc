"""A zero that moved is told as one angle, and not as links, springs and a leaning base."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pinocchio as pin
import pytest
from residual_helpers import declared_model, diagnosed, recorded, told

from hand_load_estimator.report.diagnosis_page import headline
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.doubts.moved_zero import IMITATED


def moved(joint, angle):
    """Return the Evidence of an arm whose joint is recorded too far by an angle [rad]."""
    return [replace(e, motion=replace(e.motion, q=e.motion.q + angle * (np.arange(4) == joint)))
            for e in recorded()]


@pytest.mark.parametrize('joint, angle', [(1, 0.05), (2, -0.3)])
def test_it_is_told_with_its_joint_and_angle(joint, angle):
    evidence = moved(joint, angle)
    diagnosis, _ = diagnose(declared_model(), evidence[:-1], evidence[-1:])
    assert not set(told(diagnosis)) & set(IMITATED)
    assert f'zero of j{joint} seems to have moved' in diagnosis.moved_zero
    said = float(diagnosis.moved_zero.split('recorded ')[1].split(' ')[0])
    assert said == pytest.approx(angle, rel=0.02)
    assert headline(diagnosis) == diagnosis.moved_zero
    assert any(f'the angle of j{joint}, recorded' in text for text in diagnosis.remains)


@pytest.mark.parametrize('moments', [
    [0.3, 0.01, 0.03, -0.02, 2e-3, 0.0, 2e-3, 0.0, 0.0, 2e-3],
    # Sideways a centre of mass moves as if the joint had turned, but not quite.
    [0.0, 0.2, *[0.0] * 8]])
def test_a_link_that_has_changed_is_no_zero(moments):
    robot = declared_model().robot
    products = np.zeros(40)
    products[20:30] = moments

    def other(run):
        return np.array([robot.link_regressor(*row) @ products
                         for row in zip(run.x.q, run.x.v, run.x.a)])
    diagnosis, _ = diagnosed(other)
    assert told(diagnosis) == {'link_inertia': (robot.joints[2],)}
    assert not diagnosis.moved_zero


def test_on_a_wall_a_base_turned_about_the_first_axis_is_told_as_well():
    """A bracket that sits askew had been an encoder that had moved, and nothing else."""
    hanging = four_axes(gravity=[9.81, 0.0, 0.0])
    plain = declared_model.__wrapped__()
    model, angle = replace(plain, robot=hanging), 0.03
    turned = hanging.model.copy()
    turned.gravity.linear = 9.81 * np.array([np.cos(angle), np.sin(angle), 0.0])
    data = turned.createData()
    evidence = []
    for e in recorded():
        change = [pin.computeGeneralizedGravity(turned, data, q) for q in e.motion.q]
        fixed = np.array(change) - [plain.robot.rigid_torque(q, 0.0 * q, 0.0 * q)
                                    for q in e.motion.q]
        evidence.append(replace(e, torque=e.torque + fixed))
    diagnosis, _ = diagnose(model, evidence[:-1], evidence[-1:])
    assert 'zero of j0' in diagnosis.moved_zero
    assert 'or the base is mounted turned about it' in diagnosis.moved_zero
    (lean,) = (f for f in diagnosis.findings if f.name == 'base_tilt')
    gravity = np.array([lean.parameters[f'gravity_{axis}'][0] for axis in 'xyz'])
    np.testing.assert_allclose(gravity, turned.gravity.linear, atol=0.05)
    assert np.linalg.norm(gravity) == pytest.approx(9.81)
