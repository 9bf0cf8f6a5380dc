"""`hand_load check` names each thing that can be wrong with a recording, and only that."""

from dataclasses import replace
import json
import os
from pathlib import Path

from check_helpers import (CENTRE, FRICTION, RATE, VISCOUS, changed_robot, only, recording,
                           swings, torque, verdicts)
from hand_load_estimator.checks.recording_check import check_recording
from hand_load_estimator.cli import main
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.plant import JointEvent, simulate_motion
from hand_load_estimator.recording import JointSample, RecordingWriter
from hand_load_estimator.robot import load_robot
from hand_load_estimator.simulation.simulate_motions import named_motion
from hand_load_estimator.stream.joint_stream import motion_of
import numpy as np
import pytest

DATA = Path(os.environ.get('HAND_LOAD_DATA', Path(__file__).parents[2] / 'shared' / 'data'))


@pytest.fixture(scope='module')
def robot():
    return load_robot(find_shared('ur10e', 'robots'))


@pytest.fixture(scope='module')
def motion():
    return swings()


def test_a_good_recording_is_ok(robot, motion):
    check = check_recording(recording(robot, motion, torque(robot, motion)), robot)
    only({f.item: f.verdict for f in check.findings})
    # Gains of the joints that carry weight come out as 1, friction as it was put in.
    assert check.joints['shoulder_lift_joint']['gain'] == pytest.approx(1.0, abs=0.02)
    speed = np.abs(motion[2][:, 1]).mean()
    assert check.joints['shoulder_lift_joint']['friction'] == pytest.approx(
        FRICTION[1] + VISCOUS[1] * speed, rel=0.1)


def test_amperes_taken_for_newton_metres(robot, motion):
    found = verdicts(robot, recording(robot, motion, torque(robot, motion) / 11.0))
    only(found, effort_unit='wrong')


def test_newton_metres_taken_for_amperes(robot, motion):
    current = load_robot(find_shared('ur10e_current', 'robots'))
    found = verdicts(current, recording(robot, motion, torque(robot, motion)))
    assert found['effort unit'] == 'wrong'
    assert found['saturation'] == 'doubt'


def test_thousandths_of_newton_metres_are_named(robot, motion):
    """The estimator rejects all of them; a few broken messages are no unit."""
    effort = torque(robot, motion)
    still = (motion[0], np.tile(CENTRE, (len(motion[0]), 1)), *(0.0 * x for x in motion[2:]))
    for made in (recording(robot, motion, 1000.0 * effort),
                 recording(robot, still, 1000.0 * torque(robot, still))):
        unit, = [f for f in check_recording(made, robot).findings if f.item == 'effort unit']
        assert unit.verdict == 'wrong' and 'looks like mNm' in unit.todo
    effort[::200] *= 1000.0
    made = recording(robot, motion, effort)
    unit, = [f for f in check_recording(made, robot).findings if f.item == 'effort unit']
    assert 'rejected' not in unit.text


@pytest.mark.parametrize('velocity', [lambda v: v[:0], lambda v: np.nan * v,
                                      lambda v: np.r_[np.nan, v[1:]], lambda v: v[:3]])
def test_what_is_said_of_missing_velocities_is_what_the_estimator_does(robot, motion, velocity):
    made = recording(robot, motion, torque(robot, motion))
    made = replace(made, samples=[
        replace(s, velocity=velocity(s.velocity)) if isinstance(s, JointSample) else s
        for s in made.samples])
    _, rejected = motion_of(robot, made)
    values, = [f for f in check_recording(made, robot).findings if f.item == 'values']
    assert (values.verdict == 'ok') == (not rejected)
    assert ('rejected' in values.todo) == bool(rejected)
    if not rejected:
        only(verdicts(robot, made))


def test_one_reversed_joint(robot, motion):
    effort = torque(robot, motion)
    effort[:, 2] *= -1.0
    check = check_recording(recording(robot, motion, effort), robot)
    sign, = [f for f in check.findings if f.item == 'effort sign']
    assert sign.verdict == 'wrong'
    assert sign.text.endswith('elbow_joint')


def test_all_joints_reversed_is_not_taken_for_a_ceiling(robot, motion):
    found = verdicts(robot, recording(robot, motion, -torque(robot, motion)))
    assert found['effort sign'] == 'wrong'
    assert found['gravity'] == 'ok'


@pytest.mark.parametrize('gravity', [[0.0, 0.0, 9.81], [9.81, 0.0, 0.0], [0.0, -6.94, -6.94]])
def test_mounting_is_found(robot, motion, gravity):
    made = recording(robot, motion, torque(robot, motion, gravity))
    finding, = [f for f in check_recording(made, robot).findings if f.item == 'gravity']
    assert finding.verdict == 'wrong'
    fitted = json.loads(finding.text.split('fitted ')[1])
    assert fitted == pytest.approx(gravity, abs=0.3)
    assert verdicts(changed_robot(robot, gravity=gravity), made)['gravity'] == 'ok'


def test_a_small_tilt_is_a_doubt(robot, motion):
    tilt = np.radians(8.0)
    gravity = [9.81 * np.sin(tilt), 0.0, -9.81 * np.cos(tilt)]
    found = verdicts(robot, recording(robot, motion, torque(robot, motion, gravity)))
    assert found['gravity'] == 'doubt'


@pytest.fixture(scope='module')
def excited(robot):
    """Return motion and effort of an arm whose friction builds up after each reversal."""
    asked = named_motion('excite', robot, 24.0, seed=1)
    states = [e for e in simulate_motion(robot, asked.time, asked.position, asked.velocity,
                                         asked.acceleration, seed=1, rate=RATE)
              if isinstance(e, JointEvent)]
    t, q, v, effort = (np.array([getattr(s, name) for s in states])
                       for name in ('stamp', 'position', 'velocity', 'effort'))
    return (t, q, v, None), effort


def delay_of(robot, made):
    return next(f for f in check_recording(made, robot).findings if f.item == 'delay')


@pytest.mark.parametrize('late, verdict', [(0.0, 'ok'), (0.03, 'doubt'), (0.08, 'wrong')])
def test_delay(robot, excited, late, verdict):
    motion, effort = excited
    made = recording(robot, motion, np.roll(effort, int(late * RATE), axis=0))
    finding = delay_of(robot, made)
    assert finding.verdict == verdict
    assert float(finding.text.split()[1]) == pytest.approx(1e3 * late, abs=5.0)


def test_a_slow_motion_tells_no_delay(robot, motion):
    slower = 15.0
    t = np.arange(0.0, slower * motion[0][-1], 0.02)
    q, v, a = (np.column_stack([np.interp(t / slower, motion[0], column) for column in part.T])
               / slower ** k for k, part in enumerate(motion[1:]))
    slow = t, q, v, a
    finding = delay_of(robot, recording(robot, slow, torque(robot, slow)))
    assert finding.verdict == 'cannot tell' and 'max_velocity' in finding.text


def test_a_cut_off_effort_is_told_and_not_judged(robot, motion):
    check = check_recording(recording(robot, motion, np.clip(torque(robot, motion), -30.0, 30.0)),
                            robot)
    only({f.item: f.verdict for f in check.findings}, saturation='doubt')
    saturation, = [f for f in check.findings if f.item == 'saturation']
    for joint in ('shoulder_lift_joint', 'elbow_joint'):
        assert f'{joint} at 30 Nm' in saturation.text and joint not in check.joints


@pytest.mark.filterwarnings('error')
def test_dead_efforts_are_told_and_have_no_unit(robot, motion):
    check = check_recording(recording(robot, motion, 0.0 * torque(robot, motion)), robot)
    effort, = [f for f in check.findings if f.item == 'effort']
    assert effort.verdict == 'wrong' and 'wrist_3_joint stays at 0 Nm' in effort.text
    assert 'effort unit' not in {f.item for f in check.findings}


def test_a_torque_constant_needs_a_gain(robot, motion):
    """Friction alone tells none."""
    effort = torque(robot, motion) - torque(robot, motion, friction=0.0)
    unit, = [f for f in check_recording(recording(robot, motion, effort), robot).findings
             if f.item == 'effort unit']
    assert unit.verdict == 'wrong' and 'Nm/A' not in unit.todo
    unit, = [f for f in check_recording(recording(robot, motion, torque(robot, motion) / 11.0),
                                        robot).findings if f.item == 'effort unit']
    assert 'Nm/A' in unit.todo


def test_effort_without_gravity(robot, motion):
    effort = torque(robot, motion) - torque(robot, motion, friction=0.0) \
        + torque(robot, motion, [0.0, 0.0, 0.0], friction=0.0)
    found = verdicts(robot, recording(robot, motion, effort))
    assert found['compensation'] == 'wrong'
    assert found['effort unit'] == 'wrong'


LOAD = LoadParameters(8.0, [0.0, 0.02, 0.1], 0.03 * np.eye(3))


def test_a_load_that_the_driver_takes_off_is_put_back(robot, motion):
    """UR drivers take the payload that is set on the robot off the torque they report."""
    effort = {'kind': 'motor_torque', 'includes_configured_load': True,
              'configured_load': {'mass': LOAD.mass, 'com': LOAD.com.tolist()}}
    told = changed_robot(robot, effort=effort)
    taken_off = [told.configured_torque(q) for q in motion[1]]
    known = ('mass', 'com', 'inertia')
    for load in (LOAD, LoadParameters()):
        reported = torque(robot, motion, load=load) - taken_off
        only(verdicts(told, recording(robot, motion, reported, load, known)))
    held = recording(robot, motion, torque(robot, motion, load=LOAD) - taken_off, LOAD, known)
    assert verdicts(robot, held)['load'] == 'wrong'


def test_load_is_seen_missed_or_not_stated(robot, motion):
    loaded, bare = torque(robot, motion, load=LOAD), torque(robot, motion)
    known = ('mass', 'com', 'inertia')
    only(verdicts(robot, recording(robot, motion, loaded, LOAD, known)))
    only(verdicts(robot, recording(robot, motion, bare, LoadParameters(), known)))
    assert verdicts(robot, recording(robot, motion, bare, LOAD, known))['load'] == 'wrong'
    assert verdicts(robot, recording(robot, motion, loaded))['load'] == 'doubt'
    check = check_recording(recording(robot, motion, loaded), robot)
    text, = [f.text for f in check.findings if f.item == 'load']
    assert float(text.split('looks like ')[1].split()[0]) == pytest.approx(8.0, abs=0.5)


def test_less_than_no_load_is_the_links(robot, motion):
    held = LoadParameters(3.0, LOAD.com)
    lighter = 2.0 * torque(robot, motion) - torque(robot, motion, load=held)
    found = verdicts(robot, recording(robot, motion, lighter))
    assert found['link masses'] == 'doubt' and 'load' not in found


def test_link_torque_needs_no_friction(robot, motion):
    effort = {'kind': 'link_torque', 'includes_configured_load': False}
    made = recording(robot, motion, torque(robot, motion, friction=0.0))
    only(verdicts(changed_robot(robot, effort=effort), made))


def test_degrees_and_wrong_velocity(robot, motion):
    t, q, v, a = motion
    effort = torque(robot, motion)
    degrees = verdicts(robot, recording(robot, (t, np.degrees(q), np.degrees(v), a), effort))
    assert degrees['position'] == 'wrong'
    for wrong in (np.degrees(v), -v):
        found = verdicts(robot, recording(robot, (t, q, wrong, a), effort))
        assert found['velocity'] == 'wrong'


def test_other_joints_only(robot, motion):
    names = tuple('xyzuvw')
    found = verdicts(robot, recording(robot, motion, torque(robot, motion), names=names))
    assert found['joints'] == 'wrong'
    assert 'effort unit' not in found


@pytest.mark.parametrize('broken', ['nan', 'no effort', 'still', 'short', 'empty'])
def test_odd_data_never_raises(robot, motion, broken):
    t, q, v, a = (x[:1200].copy() for x in motion)
    effort = torque(robot, (t, q, v, a))
    if broken == 'nan':
        q[100:200, 2], effort[500:520] = np.nan, np.nan
    elif broken == 'no effort':
        effort[:] = np.nan
    elif broken == 'still':
        q[:], v[:] = q[0], 0.0
    else:
        keep = 30 if broken == 'short' else 0
        t, q, v, effort = t[:keep], q[:keep], v[:keep], effort[:keep]
    found = verdicts(robot, recording(robot, (t, q, v, a), effort))
    assert any(verdict != 'ok' for verdict in found.values())


def test_command_prints_table_and_json(robot, motion, tmp_path, capsys):
    made = recording(robot, motion, torque(robot, motion))
    with RecordingWriter(tmp_path / 'bag') as writer:
        for sample in made.samples:
            writer.write(sample)
    assert main(['check', str(tmp_path / 'bag'), '--robot', 'ur10e']) == 0
    table = capsys.readouterr().out
    assert 'effort unit' in table and 'elbow_joint' in table
    assert main(['check', str(tmp_path / 'bag'), '--robot', 'ur10e', '--json']) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer['schema'] == 'hand_load/check/1'
    assert {f['verdict'] for f in answer['findings']} == {'ok'}
    assert main(['check', str(tmp_path / 'bag'), '--robot', 'ur10e', '--joint-states', 'x']) == 2


def test_a_wrong_row_ends_with_one(robot, motion, tmp_path, capsys):
    made = recording(robot, motion, torque(robot, motion) / 11.0)
    with RecordingWriter(tmp_path / 'bag') as writer:
        for sample in made.samples:
            writer.write(sample)
    for more in ((), ('--json',)):
        assert main(['check', str(tmp_path / 'bag'), '--robot', 'ur10e', *more]) == 1
        assert 'wrong' in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(['check', '--help'])
    assert 'exit status is 1' in ' '.join(capsys.readouterr().out.split())


real = pytest.mark.skipif(not (DATA / 'ur10e').is_dir(), reason=f'no recordings at {DATA}')


@real
@pytest.mark.parametrize('run', ['ident_20_02_12-50sec_12harm', 'ident_20_01_13-load_2600',
                                 'valid_20_01_17-ptp_10_points', 'ident_19_09_27-11_28_22'])
def test_real_arm_in_amperes(run, capsys):
    path = str(DATA / 'ur10e' / run)
    assert main(['check', path, '--robot', 'ur10e_current', '--json']) == 0
    found = {f['item']: f['verdict'] for f in json.loads(capsys.readouterr().out)['findings']}
    only(found, temperatures='doubt')
    assert main(['check', path, '--robot', 'ur10e', '--json']) == 1
    found = {f['item']: f['verdict'] for f in json.loads(capsys.readouterr().out)['findings']}
    only(found, temperatures='doubt', effort_unit='wrong')


@real
def test_real_arm_standing_cannot_tell(capsys):
    assert main(['check', str(DATA / 'ur10e' / 'valid_20_01_17-p3'), '--robot', 'ur10e_current',
                 '--json']) == 0
    found = {f['item']: f['verdict'] for f in json.loads(capsys.readouterr().out)['findings']}
    assert found['effort unit'] == found['motion'] == 'cannot tell'
