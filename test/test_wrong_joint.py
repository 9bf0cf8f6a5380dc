"""One joint recorded wrongly is refused with what was mixed up; what arms have is not."""

from dataclasses import replace

from core_helpers import block, exact_model, four_axes
from effect_helpers import waves
import numpy as np
import pytest
from residual_helpers import cable, constant_friction, declared_model, on, recorded, viscous

from hand_load_estimator.errors import RecordingError
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.residual.doubts.another_robot import refuse_another_robot
from hand_load_estimator.residual.doubts.wrong_joint import wrong_joint


def told(torque=None, **motion):
    """Return what is said of a good run with other torques, or angles."""
    run = recorded()[0]
    changed = replace(run.motion, **motion)
    return wrong_joint(declared_model(), [replace(run, motion=changed, torque=run.torque
                                                  if torque is None else torque)])


def turned(*joints):
    """Return q, v, a of a run with some angles that count the other way."""
    motion = recorded()[0].motion
    signs = np.where(np.isin(np.arange(4), joints), -1.0, 1.0)
    return {name: getattr(motion, name) * signs for name in ('q', 'v', 'a')}


def test_good_recordings_are_let_through():
    assert told() == ''


@pytest.mark.parametrize('joint', range(4))
def test_an_effort_of_the_other_sign_is_named(joint):
    torque = recorded()[0].torque.copy()
    torque[:, joint] *= -1.0
    assert f'effort of j{joint} has the other sign' in told(torque)


@pytest.mark.parametrize('joint', range(4))
def test_an_effort_without_its_sign_is_named(joint):
    torque = recorded()[0].torque.copy()
    torque[:, joint] = np.abs(torque[:, joint])
    assert f'effort of j{joint} is taken for its size without a sign' in told(torque)


@pytest.mark.parametrize('joint', range(4))
def test_an_angle_of_the_other_sign_is_named(joint):
    said = told(**turned(joint))
    # Without gravity on it the sign of a joint's angle and that of its effort are the same.
    assert f'the angle of j{joint} counts the other way' in said \
        or joint == 0 and 'the effort of j0 has the other sign' in said


@pytest.mark.parametrize('value', [0.0, 3.0])
def test_an_effort_that_tells_nothing_is_named(value):
    torque = recorded()[0].torque.copy()
    torque[:, 2] = value
    assert told(torque).startswith('the effort of j2 tells nothing')


def test_exchanged_joints_are_named():
    run, order = recorded()[0], [0, 2, 1, 3]
    assert 'the efforts of j1 and j2 are exchanged' in told(run.torque[:, order])
    motion = {name: getattr(run.motion, name)[:, order] for name in ('q', 'v', 'a')}
    assert 'angles and efforts of j1 and j2 are exchanged' in told(run.torque[:, order], **motion)


def test_an_effort_in_another_unit_is_named():
    torque = recorded()[0].torque.copy()
    torque[:, 1] *= 0.01
    assert 'but 0.0' in told(torque) and 'times at j1' in told(torque)


@pytest.mark.parametrize('hidden', [
    (1, 8.0, viscous), (2, 8.0, cable), (3, 8.0, viscous), (1, 20.0, cable),
    (1, 40.0, constant_friction), (3, 40.0, constant_friction)])
def test_what_an_arm_has_of_its_own_is_none(hidden):
    model = declared_model()
    for run in recorded(on(*hidden)):
        assert wrong_joint(model, [run]) == ''


def test_a_known_load_is_of_the_arm_and_not_of_the_effort():
    run, load, model = recorded()[0], block(2.0), declared_model()
    held = np.array([model.robot.load_regressor(*row) @ load.to_products() for row in
                     zip(run.motion.q, run.motion.v, run.motion.a)])
    assert np.sqrt(np.mean(held[:, 1] ** 2)) > 10.0 * model.noise[1]
    assert wrong_joint(model, [replace(run, load=load)]) == ''
    reported = run.torque + held
    reported[:, 1] *= -1.0
    said = wrong_joint(model, [replace(run, load=load, torque=reported - held)])
    assert 'effort of j1 has the other sign' in said


def test_a_configured_load_was_taken_off_before_the_mistake():
    entry = {'mass': 2.0, 'com': [0.02, -0.03, 0.1], 'inertia': [0.0] * 6}
    robot = four_axes(effort={'kind': 'motor_torque', 'includes_configured_load': True,
                              'configured_load': entry})
    model, run, zero = replace(declared_model(), robot=robot), recorded()[0], np.zeros(4)
    taken_off = np.array([robot.load_regressor(q, zero, zero)
                          @ robot.effort.configured_load.to_products() for q in run.motion.q])
    assert wrong_joint(model, [run]) == ''
    reported = run.torque - taken_off
    reported[:, 1] *= -1.0
    said = wrong_joint(model, [replace(run, torque=reported + taken_off)])
    assert 'effort of j1 has the other sign' in said


def test_an_arm_that_creeps_is_not_judged():
    torque = recorded()[0].torque.copy()
    torque[:, 1] *= -1.0
    slow = {'v': 0.03 * np.sign(recorded()[0].motion.v)}
    assert told(torque) != '' and told(torque, **slow) == ''


def test_the_wrong_one_among_good_recordings_is_named():
    runs = recorded()
    torque = runs[2].torque.copy()
    torque[:, 1] *= -1.0
    with pytest.raises(RecordingError, match='^run 2: .*effort of j1 has the other sign'):
        refuse_another_robot(declared_model(), [*runs[:2], replace(runs[2], torque=torque)])


def of_alike_wrists(change=lambda motion: 0.0):
    """Return a run (Evidence) of an arm whose wrists 2 and 3 are alike, with torques added."""
    model, rng = exact_model('ur10e', doubt=0.01), np.random.default_rng(3)
    motion = waves(model.robot, rng, 16.0, 25.0)
    torque = model.torques(motion.q, motion.v, motion.a, motion.temperature) + change(motion)
    return Evidence('run', motion, torque + rng.normal(size=torque.shape) * model.noise)


def test_wrists_that_are_alike_are_named_where_they_are_exchanged():
    """Though no joint is far off: what is left is a few times its noise."""
    model, run, order = exact_model('ur10e', doubt=0.01), of_alike_wrists(), [0, 1, 2, 3, 5, 4]
    names = ('q', 'v', 'a', 'temperature', 'effort')
    exchanged = replace(run, torque=run.torque[:, order], motion=replace(run.motion, **{
        name: getattr(run.motion, name)[:, order] for name in names}))
    assert wrong_joint(model, [run]) == ''
    assert 'wrist_2_joint and wrist_3_joint are exchanged' in wrong_joint(model, [exchanged])


@pytest.mark.parametrize('joint', [4, 5])
@pytest.mark.parametrize('times', [-8.0, -6.0, 6.0, 8.0])
@pytest.mark.parametrize('kind', [lambda m: np.sign(m.v), lambda m: np.ones_like(m.v),
                                  lambda m: m.v, lambda m: m.a])
def test_what_one_of_two_alike_wrists_has_is_no_exchange(joint, times, kind):
    model = exact_model('ur10e', doubt=0.01)

    def change(motion):
        own = kind(motion)[:, joint]
        return np.outer(times * model.noise[joint] * own / np.sqrt(np.mean(own ** 2)),
                        np.eye(6)[joint])
    assert wrong_joint(model, [of_alike_wrists(change)]) == ''
