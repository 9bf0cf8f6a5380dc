"""`hand_load identify` refuses recordings of which no model can be made, and writes nothing."""

from dataclasses import replace

from core_helpers import exact_model, messages, recording_of
from diagnose_helpers import write
import numpy as np
import pytest
import yaml

from hand_load_estimator.cli import main
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.identification.useless_recording import refuse_useless
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.stream.joint_stream import motion_of

EFFECTS = 'coulomb_friction,viscous_friction,torque_offset'


def stream(change):
    """Return Messages of the four-axis arm with efforts changed: change((N, n)) -> (N, n)."""
    states = messages(exact_model('four'), LoadParameters(), 12.0, seed=1, size=1.2)
    efforts = change(np.array([state.effort for state in states]))
    return [replace(s, effort=e) for s, e in zip(states, efforts)]


def at_joint(j, change):
    """Return a change of one joint's efforts."""
    def changed(efforts):
        return np.where(np.arange(efforts.shape[1]) == j, change(efforts), efforts)
    return changed


def now_and_then_beyond(share):
    """Return a change after which so many messages are rejected."""
    def changed(efforts):
        often = np.random.default_rng(3).random(len(efforts)) < share
        return np.where(often[:, None], 1e4, efforts)
    return changed


def identify(folder, states):
    """Run the command on Messages; return its status and whether it wrote a model."""
    robot, out = exact_model('four').robot, folder / 'model.yaml'
    (folder / 'arm.yaml').write_text(yaml.safe_dump(robot.file.content))
    write(folder / 'run', states)
    return main(['identify', str(folder / 'run'), '--robot', str(folder / 'arm.yaml'),
                 '--effects', EFFECTS, '--out', str(out)]), out.exists()


@pytest.mark.parametrize('change, words', [
    (np.zeros_like, ['j0 stays at 0 Nm, j1 stays at 0 Nm', 'hand_load check']),
    (at_joint(1, lambda efforts: 0.0 * efforts + 3.0), ['run: ', 'j1 stays at 3 Nm']),
    (at_joint(1, lambda efforts: np.maximum(efforts, -1.0)),
     ['run: ', 'j1 stands at an end of its range in 9']),
    (np.negative, ['run: ', 'of the 4 joints that carry weight', 'other sign']),
    (now_and_then_beyond(0.6), ['run were rejected (', ' implausible effort', 'robot file'])],
    ids=['dead', 'one dead', 'cut off', 'reversed', 'another unit'])
def test_what_tells_nothing_ends_with_two_and_no_model(change, words, tmp_path, capsys):
    assert identify(tmp_path, stream(change)) == (2, False)
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert all(word in said for word in words), said


@pytest.mark.parametrize('change', [
    lambda efforts: efforts, now_and_then_beyond(0.1),
    at_joint(1, lambda efforts: np.maximum(efforts, -3.0))])
def test_what_tells_enough_becomes_a_model(change, tmp_path):
    assert identify(tmp_path, stream(change)) == (0, True)


def test_joint_states_published_thrice_lose_nothing(tmp_path):
    states = [state for state in stream(np.copy) for _ in range(3)]
    assert identify(tmp_path, states) == (0, True)


def test_the_reasons_of_rejections_are_printed(tmp_path, capsys):
    identify(tmp_path, stream(now_and_then_beyond(0.1)))
    assert 'implausible effort)' in capsys.readouterr().err.splitlines()[0]


def evidence_of(states, **changes):
    robot = exact_model('four').robot
    made = recording_of(states, robot.joints)
    motion, rejected = motion_of(robot, made)
    return replace(prepare(robot, 'run', motion, LoadParameters(), made, rejected), **changes)


def test_a_held_joint_may_report_one_effort():
    held = [replace(s, position=np.r_[s.position[0], 0.3, s.position[2:]],
                    velocity=np.r_[s.velocity[0], 0.0, s.velocity[2:]])
            for s in stream(at_joint(1, np.zeros_like))]
    refuse_useless(exact_model('four').robot, evidence_of(held))


def test_temperatures_and_gaps_are_no_rejected_joint_states():
    many = {'implausible_temperature': 10 ** 5, 'gap': 10 ** 5}
    refuse_useless(exact_model('four').robot, evidence_of(stream(np.copy), rejected=many))
