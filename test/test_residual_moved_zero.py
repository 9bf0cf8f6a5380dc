"""A zero that moved is told as one angle, and not as links, springs and a leaning base."""

from dataclasses import replace

import numpy as np
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
