"""Offline rivals find a load from exact torques; each needs its package and is skipped without."""

import sys

from core_helpers import block, exact_model, four_axes, messages
import numpy as np
import pytest

from hand_load_estimator.benchmark import offline
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.motion import MotionSample


def run(noise=0.0, seconds=6.0):
    """Return a LoadedRun of a small arm that moves all joints with a 2 kg block."""
    robot, rng = four_axes(), np.random.default_rng(4)
    stamp = np.arange(0.0, seconds, 0.02)
    omega, phase = 2.0 * np.pi * rng.uniform(0.2, 0.6, 4), rng.uniform(0.0, 6.0, 4)
    q = np.sin(np.outer(stamp, omega) + phase)
    v = omega * np.cos(np.outer(stamp, omega) + phase)
    a = -omega ** 2 * q
    products = block(2.0).to_products()
    torque = np.array([robot.load_regressor(*row) @ products for row in zip(q, v, a)])
    torque += noise * rng.normal(size=torque.shape)
    return offline.LoadedRun(stamp, q, v, a, torque, np.ones_like(q) / max(noise, 0.01))


@pytest.mark.parametrize('name', offline.RIVALS)
def test_a_rival_finds_the_load(name):
    try:
        identify = offline._identify(name)
    except ConfigurationError as error:
        pytest.skip(str(error))
    truth = block(2.0).to_message()
    mean, std = identify(four_axes(), run(noise=0.02))
    assert np.isfinite(std).all() and (std > 0.0).all()
    assert abs(mean[0] - truth[0]) < 0.02
    np.testing.assert_allclose(mean[1:4], truth[1:4], atol=0.005)
    assert (np.abs(mean - truth) < 6.0 * std + 1e-4).all()


def test_a_rival_without_its_package_says_how_to_get_it(monkeypatch):
    # Where it is installed its parts may be loaded already.
    for name in ('figaroh', 'figaroh.identification.identification_tools'):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, 'hand_load_estimator.benchmark.rival_figaroh', raising=False)
    with pytest.raises(ConfigurationError, match='figaroh.*pip install figaroh'):
        offline.chosen_rivals(('figaroh',))


def test_rivals_get_the_run_so_far_and_no_standing_joints():
    model, zero = exact_model('four'), np.zeros(4)
    samples = [MotionSample(m.stamp, 0.02, m.position, m.velocity, zero, m.effort, zero, False)
               for m in messages(model, block(2.0), 2.0, rate=50.0, noisy=False)]
    found = offline.loaded_run(model, samples)
    assert found.torque.shape == found.weight.shape == (len(samples), 4)
    still = np.abs(found.v) < 0.02
    assert (found.weight[still] == 0.0).all() and (found.weight[~still] > 0.0).all()
    part = found.until(samples[10].stamp)
    assert len(part.stamp) == len(part.q) == 11


def test_a_failed_rival_is_a_sentence(monkeypatch):
    def fail(robot, run):
        raise np.linalg.LinAlgError('singular')

    monkeypatch.setattr(offline, '_identify', lambda name: fail)
    model, zero = exact_model('four'), np.zeros(4)
    samples = [MotionSample(m.stamp, 0.02, m.position, m.velocity, zero, m.effort, zero, False)
               for m in messages(model, block(2.0), 1.0, rate=50.0, noisy=False)]
    found = offline.offline_beliefs(('figaroh',), four_axes(), model, samples, 0.1)
    assert found['figaroh'] == dict.fromkeys(('3 s', '10 s', 'end'), 'LinAlgError: singular')
    assert offline.offline_beliefs((), four_axes(), model, samples, 0.1) == {}
