"""An arm that is held in a pose and pushed: contacts are told, nothing else is made up."""

from dataclasses import replace
import warnings

from core_helpers import messages
from diagnose_helpers import (assert_schema, diagnosed, EMPTY, model, recorded, refused, run,
                              SECONDS, write)
import numpy as np
import pytest

from hand_load_estimator.residual.outside.standing import BREAKS

PUSH = (4.0, 5.0)      # [s]


def hold():
    """Return what friction can hold (n,) [Nm]."""
    return model().friction_level() + model().noise


def standing(torque=None, force=None, seed=7):
    """Return Messages of an arm that stands and is pushed by torques (n,) or a force (3,)."""
    out = []
    for m in messages(model(), EMPTY, SECONDS, seed=seed, rest=99.0):
        effort, time = np.array(m.effort), m.stamp - 100.0
        if PUSH[0] < time < PUSH[1]:
            effort = effort + (-model().robot.hand_jacobian(m.position).T @ force
                               if torque is None else torque)
        out.append(replace(m, effort=effort))
    return out


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a model and recordings of the arm."""
    return recorded(tmp_path_factory.mktemp('standing'))


def contact_in(folder, *recordings):
    """Return (the one effect that a diagnosis finds, its report)."""
    with warnings.catch_warnings():
        warnings.simplefilter('error', RuntimeWarning)
        status, report = diagnosed(folder, *recordings)
    assert status == 0
    (effect,) = report['effects']
    assert (effect['name'], effect['verdict']) == ('external_contact', 'confirmed')
    for edge, time in zip(('start', 'end'), PUSH):
        found = effect['parameters'][edge]
        assert abs(found['mean'] - time) < 2.0 * found['std']
    return effect, report


def test_a_push_of_the_hand_is_a_force(folder, capsys):
    force = np.array([80.0, -60.0, 70.0])
    write(folder / 'pushed', standing(force=force))
    effect, report = contact_in(folder, 'pushed')
    assert effect['recording'] == 'pushed'
    for axis, newtons in zip('xyz', force):
        found = effect['parameters'][f'force_{axis}']
        assert abs(found['mean'] - newtons) < 2.0 * found['std'] and found['std'] < 60.0
    # Friction at rest hides the rest, which is said and given no numbers.
    assert report['before']['torque_rmse'] == [None] * 4 and report['structure'] is None
    assert any('no joint moves' in s for s in report['cannot_tell'])
    said = capsys.readouterr().out
    assert 'external contact found; torque error' in said and 'not known Nm' not in said
    assert (folder / 'out' / 'model.yaml').read_text() == (folder / 'old.yaml').read_text()


def test_a_push_of_another_link_is_torques(folder):
    write(folder / 'leaned on', standing(torque=np.array([0.0, 5.0, 0.0, 0.0]) * hold()))
    effect, report = contact_in(folder, 'leaned on')
    assert effect['joints'] == ['j1']
    found = effect['parameters']['torque (j1)']
    assert abs(found['mean'] - 5.0 * hold()[1]) < 2.0 * found['std']
    assert any('where on the arm' in s for s in report['cannot_tell'])


def test_among_recordings_in_motion_it_is_found_too(folder):
    if not (folder / 'pushed').exists():
        write(folder / 'pushed', standing(force=np.array([80.0, -60.0, 70.0])))
    effect, report = contact_in(folder, 'clean1', 'clean2', 'pushed')
    assert effect['recording'] == 'pushed' and None not in report['before']['torque_rmse']
    assert_schema(report)


def test_what_friction_can_hold_is_no_contact(folder, capsys):
    write(folder / 'touched', standing(torque=0.6 * BREAKS * hold()))
    assert 'no joint moves' in refused(folder, capsys, 'touched')


def test_a_weight_all_the_time_is_no_contact(folder, capsys):
    """The declared load is wrong, or the model is another arm's."""
    write(folder / 'heavy', [replace(m, effort=m.effort + 4.0 * hold()) for m in standing(
        torque=np.zeros(4))])
    said = refused(folder, capsys, 'heavy')
    assert 'the arm stands' in said and 'friction can hold' in said and 'load' in said


def test_a_joint_that_a_push_shakes_has_not_moved(folder):
    """For a moment it is fast; its error would be that of the push."""
    shaken = []
    for m in run(1):
        position, velocity = np.array(m.position), np.array(m.velocity)
        time = m.stamp - 100.0
        shakes = PUSH[0] < time < PUSH[0] + 0.3
        position[2] = 0.4 + 1e-3 * shakes * np.sin(60.0 * time)
        velocity[2] = 0.06 * shakes * np.cos(60.0 * time)
        shaken.append(replace(m, position=position, velocity=velocity))
    write(folder / 'shaken', shaken)
    status, report = diagnosed(folder, 'clean1', '--test', 'shaken')
    assert status == 0 and report['before']['torque_rmse'][2] is None
