"""An identified model that makes no sense is told with its joint; one that does is not."""

from dataclasses import replace

import numpy as np
import pytest
from residual_helpers import constant_friction, declared_model, on, recorded, viscous

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.identification.identified_sense import nonsense, refuse_nonsense
from hand_load_estimator.identification.identify import identify

EFFECTS = ('link_inertia', 'coulomb_friction', 'viscous_friction', 'torque_offset')


def said(change=lambda run: run, hidden=()):
    """Return what is said of the model that is identified from changed good runs."""
    runs = [change(run) for run in recorded(*hidden)]
    return list(nonsense(identify(declared_model().robot, runs, EFFECTS), runs).values())


def changed(torque=None, signs=None):
    """Return a change of a run: torque(N, n) -> (N, n), or signs (n,) of its angles."""
    def change(run):
        motion = run.motion
        if signs is not None:
            motion = replace(motion, q=signs * motion.q, v=signs * motion.v, a=signs * motion.a)
        return replace(run, motion=motion, torque=torque(run.torque) if torque else run.torque)
    return change


@pytest.mark.parametrize('hidden', [(), (on(1, 20.0, viscous), on(3, 10.0, constant_friction))])
def test_a_good_model_is_let_through(hidden):
    assert said(hidden=hidden) == []


@pytest.mark.parametrize('joint', range(4))
def test_an_effort_of_the_other_sign_is_told(joint):
    signs = np.where(np.arange(4) == joint, -1.0, 1.0)
    for how in (changed(lambda torque: signs * torque), changed(signs=signs)):
        assert any(text.startswith(f'j{joint}: ') and 'other sign' in text for text in said(how))


def test_exchanged_efforts_are_told():
    found = said(changed(lambda torque: torque[:, [0, 2, 1, 3]]))
    assert {text.split(':')[0] for text in found} & {'j1', 'j2'}
    assert 'explains less than half' in ' '.join(found) or 'drives it' in ' '.join(found)


def test_a_joint_that_never_moves_is_not_judged():
    def still(run):
        v = run.motion.v.copy()
        v[:, 0] = 0.0
        return replace(run, motion=replace(run.motion, v=v), torque=run.torque * [-1, 1, 1, 1])
    assert not any(text.startswith('j0') for text in said(still))


def test_most_joints_that_carry_weight_must_make_sense():
    robot, runs = declared_model().robot, recorded()
    wrong = {f'j{j}': f'j{j}: makes no sense' for j in range(4)}
    refuse_nonsense(robot, runs, {})
    refuse_nonsense(robot, runs, {name: wrong[name] for name in ('j0', 'j1')})
    with pytest.raises(RecordingError, match='3 of the 4 joints that carry weight .*j1, j2, j3'):
        refuse_nonsense(robot, runs, {name: wrong[name] for name in ('j1', 'j2', 'j3')})
