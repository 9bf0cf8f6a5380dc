"""A spring beside a cable on a joint that never goes round may be a further term of its pull."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, on

from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Finding, SUSPECTED
from hand_load_estimator.residual.doubts.spring_beside_cable import further_terms, WHOLE_TURN

JOINTS = declared_model().robot.joints
EVIDENCE = Evidence(100.0, 10.0, 30.0, 12, 900, 1.0)


def finding(name, gain, joint=1, verdict=CONFIRMED):
    return Finding(name, (JOINTS[joint],), {}, np.zeros(4), replace(EVIDENCE, gain=gain), (), '',
                   False, verdict)


def moved(turned):
    """Return what is read of a Residual: joint 1 goes so far [rad], and further where untold."""
    q, weights = np.zeros((50, 4)), np.ones((50, 4))
    q[:, 1] = np.linspace(0.0, turned, 50)
    q[-1, 1], weights[-1, 1] = 9.0, 0.0
    q[-2, 1] = turned
    return SimpleNamespace(x=SimpleNamespace(q=q), weights=weights)


@pytest.mark.parametrize('turned, given, sure', [
    (2.2, [('cable_drag', 900.0), ('gravity_spring', 100.0)], [True, False]),
    (2.2, [('cable_drag', 100.0), ('gravity_spring', 900.0)], [False, True]),
    (1.01 * WHOLE_TURN, [('cable_drag', 900.0), ('gravity_spring', 100.0)], [True, True]),
    (2.2, [('cable_drag', 900.0), ('viscous_friction', 100.0)], [True, True]),
    (2.2, [('cable_drag', 900.0, 0), ('gravity_spring', 100.0)], [True, True]),
    # What is suspected is in the model all the same.
    (2.2, [('cable_drag', 900.0, 1, SUSPECTED), ('gravity_spring', 100.0)], [False, False])])
def test_of_a_spring_and_a_cable_only_the_larger_is_confirmed(turned, given, sure):
    found, told = further_terms([finding(*one) for one in given], declared_model(),
                                moved(turned))
    assert [f.verdict == CONFIRMED for f in found] == sure
    lost = [one[0] for one, kept in zip(given, sure) if not kept and len(one) < 4]
    assert [text.split(' is only')[0] for text in told] == [f'{JOINTS[1]}: {n}' for n in lost]
    assert all('move the joint over a whole turn' in f.advice for f in found if f.name in lost)


def test_a_spring_beside_a_cable_that_the_model_has_is_only_suspected():
    model = SimpleNamespace(robot=declared_model().robot,
                            uses=(SimpleNamespace(name='cable_drag', joint=1),))
    (found,), (told,) = further_terms([finding('gravity_spring', 900.0)], model, moved(2.2))
    assert found.verdict == SUSPECTED and 'of the cable_drag there' in told
    other_joint = further_terms([finding('gravity_spring', 900.0, 0)], model, moved(2.2))
    assert other_joint[0][0].verdict == CONFIRMED
    # The change of a spring that it has beside the cable is no new one.
    changed = replace(finding('gravity_spring', 900.0), changed=True)
    assert further_terms([changed], model, moved(2.2))[0][0].verdict == CONFIRMED


def pulled(hidden):
    """Return the pull of a cable that no polynomial of the fourth power is equal to."""
    x = hidden.x.q - 0.3
    return x / (1.0 + 0.3 * np.abs(x)) + 0.4 * x ** 2 / (1.0 + 0.3 * x ** 2)


def test_the_pull_of_one_cable_is_no_spring_as_well():
    diagnosis, better = diagnosed(on(1, 60.0, pulled))
    names = {f.name: f.verdict for f in diagnosis.findings if f.joints == (JOINTS[1],)}
    assert names.pop('cable_drag') == CONFIRMED
    assert names == {'gravity_spring': SUSPECTED}
    assert any('a further term of the cable_drag' in text for text in diagnosis.remains)
    # Together they are nearer to it: the torque of the model written has both.
    assert {use.name for use in better.uses if use.joint == 1} >= {'cable_drag', 'gravity_spring'}
