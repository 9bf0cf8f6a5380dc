"""The estimator node is killed and goes on; it suggests a motion; it knows its tool."""

from dataclasses import replace
from functools import lru_cache
import math
from pathlib import Path
import signal
import time

from arm_data import arm_samples, box, Feeder
from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
import pytest
from std_srvs.srv import Trigger
from test_nodes_estimator import Estimator
from trajectory_msgs.msg import JointTrajectory

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.checkpoint import belongs_to, write_checkpoint
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.nodes.checkpoint_keeper import CheckpointKeeper
from hand_load_estimator.nodes.diagnostics import OK, WARN
from hand_load_estimator.nodes.qos import LATCHED
from hand_load_estimator.plant import Plant
from hand_load_estimator.robot import load_robot
from hand_load_estimator.seeds import SHIPPED_MODEL_PLANT


@lru_cache(None)
def standing(seconds=1.0, rate=250.0):
    """Return samples of the arm of arm_samples, standing with the same load."""
    plant = Plant(load_robot(find_shared('ur10e', 'robots')), seed=SHIPPED_MODEL_PLANT, rate=rate,
                  start_position=[0.0, -1.2, 1.5, -0.5, -1.0, 0.3], load=box(3.0))
    samples = []
    for _ in range(int(seconds * rate)):
        plant.step()
        samples.append((plant.time, *plant.measure()))
    return samples


def started(start, listener, *arguments):
    """Return an Estimator and a Feeder it listens to."""
    estimator, feeder = Estimator(start, listener, *arguments), Feeder(listener)
    listener.until(lambda: estimator.heard['status'], 'a status')
    feeder.wait()
    feeder.warm()
    return estimator, feeder


@pytest.fixture(scope='module')
def pipeline():
    """Return a pipeline that has found a load."""
    found = warm(pipeline_of(exact_model('four')))
    feed(found, messages(exact_model('four'), block(2.0), 2.0))
    return found


def test_a_home_of_nobody_is_refused_like_any_other_folder():
    with pytest.raises(ConfigurationError, match='no_such_user'):
        CheckpointKeeper('~no_such_user/c', 60.0)


def test_the_keeper_writes_the_newest_state_and_restores_it(pipeline, tmp_path):
    keeper = CheckpointKeeper(str(tmp_path / 'c'), 60.0)
    keeper.restore(pipeline)
    assert keeper.report()[:2] == (OK, 'no file yet')
    for _ in range(20):
        keeper.keep(pipeline, even_if_old=True)
    keeper.stop(pipeline)
    assert keeper.report()[2]['written before [s]'] < 10.0
    fresh, again = pipeline_of(exact_model('four')), CheckpointKeeper(str(tmp_path / 'c'), 60.0)
    again.restore(fresh)
    assert again.told.startswith('restored as it was')
    np.testing.assert_allclose(fresh.method.belief().mean, pipeline.method.belief().mean,
                               rtol=1e-3, atol=1e-4)
    again.stop(fresh)


def test_what_nothing_confirmed_does_not_grow_younger(pipeline, tmp_path):
    path, model = tmp_path / 'c', exact_model('four')
    write_checkpoint(path, pipeline.state(), belongs_to(pipeline), now=time.time() - 50.0)
    keeper, fresh = CheckpointKeeper(str(path), 60.0), warm(pipeline_of(model))
    keeper.restore(fresh)
    written = path.stat().st_mtime_ns
    later = [replace(m, stamp=m.stamp + 20.0) for m in messages(model, block(2.0), 2.0, rest=1.0)]
    feed(fresh, later[:80])
    assert fresh.unconfirmed and fresh.samples > 50
    keeper.keep(fresh)
    keeper.stop(fresh)
    assert path.stat().st_mtime_ns == written
    feed(fresh, later[80:])
    assert not fresh.unconfirmed
    again = CheckpointKeeper(str(path), 60.0)
    again.keep(fresh)
    again.stop(fresh)
    assert path.stat().st_mtime_ns > written


def test_what_is_in_the_file_already_is_not_written_again(pipeline, tmp_path):
    keeper = CheckpointKeeper(str(tmp_path / 'c'), 60.0)
    keeper.keep(pipeline)
    keeper.stop(pipeline)
    written = (tmp_path / 'c').stat().st_mtime_ns
    keeper.keep(pipeline)
    assert (tmp_path / 'c').stat().st_mtime_ns == written


def test_a_disk_that_takes_nothing_is_told(pipeline, tmp_path):
    folder = tmp_path / 'gone'
    folder.mkdir()
    keeper = CheckpointKeeper(str(folder / 'c'), 60.0)
    folder.rmdir()
    keeper.keep(pipeline)
    keeper.stop(pipeline)
    level, message, _ = keeper.report()
    assert level == WARN and 'cannot be written' in message


def test_without_a_file_nothing_is_kept(pipeline):
    keeper = CheckpointKeeper('', 60.0)
    keeper.restore(pipeline)
    keeper.keep(pipeline)
    keeper.stop(pipeline)
    assert keeper.report()[:2] == (OK, 'none')


def test_killed_it_goes_on_where_it_was(start, listener, tmp_path):
    path = tmp_path / 'load.checkpoint'
    estimator, feeder = started(start, listener, '-p', f'checkpoint:={path}')
    feeder.play(arm_samples((3.0,)))
    listener.until(path.is_file, 'a checkpoint')
    # Another one a second later has what was estimated last.
    estimator.work_off()
    listener.spin(1.5)
    mass, std = estimator.mass()
    assert abs(mass - 3.0) < max(0.15, 4.0 * std)
    load_id = estimator.values()['load_id']
    assert estimator.stopped(signal.SIGKILL)[0] == -signal.SIGKILL and path.is_file()
    again, feeder = started(start, listener, '-p', f'checkpoint:={path}')
    listener.until(lambda: again.values().get('checkpoint', '').startswith('restored'),
                   'the word that it was restored')
    assert '1' not in again.values()['determined'], 'nothing, before any motion'
    # The killed node still counts as a listener for a while, so nobody may have heard the first.
    for _ in range(6):
        feeder.play(standing())
        if again.heard['load_variance']:
            break
    listener.until(lambda: again.heard['load'] and again.heard['load_variance'],
                   'an estimate')
    load, variance = again.heard['load'][0].inertia, again.heard['load_variance'][0].inertia
    assert abs(load.m - mass) < std and 0.8 * std < math.sqrt(variance.m) < 1.25 * std
    assert again.values()['load_id'] == load_id, 'the same load, as far as a standing arm tells'
    listener.until(lambda: 'restored' in again.said('checkpoint')[0], 'diagnostics')
    assert again.stopped(signal.SIGTERM)[0] == 0
    assert [p.name for p in tmp_path.iterdir()] == ['load.checkpoint']


def test_a_checkpoint_it_cannot_use_does_not_stop_it(pipeline, start, listener, tmp_path):
    path = tmp_path / 'load.checkpoint'
    write_checkpoint(path, pipeline.state(), belongs_to(pipeline))
    path.write_bytes(path.read_bytes()[:-1])
    estimator, feeder = started(start, listener, '-p', f'checkpoint:={path}')
    feeder.play(standing())
    listener.until(lambda: 'refused' in estimator.said('checkpoint')[0], 'a warning')
    told = estimator.values()['checkpoint']
    assert 'damaged' in told and told.endswith(f', and the file is {path}.refused now')
    assert estimator.values()['determined'].startswith('0')
    assert estimator.stopped(signal.SIGTERM)[0] == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ['load.checkpoint',
                                                          'load.checkpoint.refused']


def test_what_never_was_a_checkpoint_stays(start, tmp_path):
    path = tmp_path / 'model.yaml'
    path.write_text('schema: hand_load/torque_model/1\n')
    node = start('estimator', '--ros-args', '-p', f'checkpoint:={path}')
    assert node.wait(30.0) == 2
    assert f"is no checkpoint and would be lost; got '{path}'" in node.output
    assert path.read_text() == 'schema: hand_load/torque_model/1\n'
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize('content', [b'', b'x' * 8 + b'{"__metadata__":{"schema":'
                                     b'"hand_load/checkpoint/0"'])
def test_what_holds_nothing_or_another_version_may_go(content, tmp_path):
    (tmp_path / 'c').write_bytes(content)
    assert CheckpointKeeper(str(tmp_path / 'c'), 60.0).told == 'no file yet'


def test_what_cannot_be_read_is_a_wrong_parameter(tmp_path, monkeypatch):
    (tmp_path / 'c').write_bytes(b'somebody else\'s')

    def denied(path):
        raise PermissionError(13, 'Permission denied')

    monkeypatch.setattr(Path, 'read_bytes', denied)
    with pytest.raises(ConfigurationError, match='cannot be read .*Permission denied'):
        CheckpointKeeper(str(tmp_path / 'c'), 60.0)


def test_a_checkpoint_in_no_folder_is_a_wrong_parameter(start, tmp_path):
    node = start('estimator', '--ros-args', '-p', f'checkpoint:={tmp_path}/none/file')
    assert node.wait(30.0) == 2
    assert 'checkpoint' in node.output and node.output.count('\n') == 1, node.output


def test_it_suggests_a_motion_and_knows_its_tool(start, listener, tmp_path):
    tool = tmp_path / 'tool.yaml'
    tool.write_text('mass: 1.25\ncom: [0, 0, 0.05]\nstd: {mass: 0.01}\n')
    estimator, feeder = started(start, listener, '-p', f'tool:={tool}')
    heard = listener.listen(JointTrajectory, 'estimator/suggested_motion', LATCHED)
    answer = listener.call(Trigger, 'estimator/suggest_motion', Trigger.Request())
    assert not answer.success and 'no usable joint states' in answer.message
    feeder.play(standing())
    answer = listener.call(Trigger, 'estimator/suggest_motion', Trigger.Request(), timeout=30.0)
    assert answer.success and 'not determined: mass' in answer.message, answer.message
    listener.until(lambda: heard, 'the motion')
    points = heard[-1].points
    assert list(heard[-1].joint_names) == list(feeder.joints) and len(points) == 2
    np.testing.assert_allclose(points[-1].positions, standing()[0][1], atol=1e-3)
    assert not any(points[-1].velocities)
    assert estimator.values()['tool mass [kg]'] == '1.25'


def test_a_file_that_another_node_keeps_is_neither_read_nor_lost(pipeline, tmp_path):
    """Two arms alike had shared one by mistake, and a tare went from one to the other."""
    path = tmp_path / 'c'
    left, right = (CheckpointKeeper(str(path), 60.0, f'/{side}/estimator')
                   for side in ('left', 'right'))
    left.keep(pipeline)
    left.stop(pipeline)
    written = path.read_bytes()
    right.keep(pipeline)
    right.stop(pipeline)
    assert path.read_bytes() == written
    level, message, _ = right.report()
    assert level == WARN and '/left/estimator keeps its own there' in message
    fresh, again = (pipeline_of(exact_model('four')),
                    CheckpointKeeper(str(path), 60.0, '/right/estimator'))
    again.restore(fresh)
    assert 'belongs to another node: /left/estimator, not /right/estimator' in again.told
    assert not fresh.unconfirmed and again.report()[0] == WARN
    assert path.read_bytes() == written and not (tmp_path / 'c.refused').exists()
