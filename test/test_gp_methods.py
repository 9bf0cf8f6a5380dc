"""Methods on the learned difference: histogram filter, regression, searches."""

import json
import os
import subprocess
import sys

from core_helpers import block, exact_model, feed, recording_of, warm
from difference_helpers import evidence, model, stream
from gp_helpers import LOAD, pipeline
import numpy as np
import pytest
from ros_helpers import ROOT

from hand_load_estimator.cli import main
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import build_method
from hand_load_estimator.estimators.gp_histogram import GpHistogram
from hand_load_estimator.estimators.gp_search import GpEvolution, GpSwarm
from hand_load_estimator.estimators.registry import ON_DIFFERENCE
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.learning.learn_difference import learn_difference
from hand_load_estimator.recording import RecordingWriter
from hand_load_estimator.torque.model_file import write_model
from hand_load_estimator.torque.model_follower import ModelFollower


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return an artefact for the arm with unknown friction."""
    out = tmp_path_factory.mktemp('gp')
    learn_difference(out, model(), evidence())
    return out


@pytest.fixture(scope='module')
def watched(folder):
    """Return {name: (Pipeline, estimates)} of two methods over one motion with a load."""
    out = {}
    for name in ('bayes', 'gp_bayes', 'gp_histogram'):
        made = pipeline(name, None if name == 'bayes' else folder)
        out[name] = made, feed(made, stream(LOAD, 5.0, seed=7))
    return out


def mass_errors(estimates, since=101.5):
    """Return absolute mass errors [kg] from a stamp on."""
    return np.array([abs(e.mean[0] - LOAD.mass) for e in estimates if e.stamp > since])


def test_e2_2_the_learned_difference_helps(watched):
    errors = {name: np.sqrt(np.mean(mass_errors(found) ** 2))
              for name, (_, found) in watched.items()}
    assert errors['gp_bayes'] < 0.6 * errors['bayes']
    assert errors['gp_histogram'] < 0.6 * errors['bayes']


@pytest.mark.parametrize('name', ['gp_bayes', 'gp_histogram'])
def test_e7_3_the_answer_is_right_within_its_interval(watched, name):
    last = watched[name][1][-1]
    assert (np.abs(last.mean - LOAD.to_message()) < 4.0 * last.std).all()
    assert last.std[0] < 0.05 and last.std[1:4].max() < 0.01
    assert watched[name][0].method.changes == 0


def test_e2_3_histogram_and_regression_agree_where_nothing_is_refused(
        watched, folder, monkeypatch):
    """Both hold the same posterior, one as candidates, the other as a normal density."""
    monkeypatch.setattr(GpHistogram, '_opens', lambda *given: True)
    histogram = feed(pipeline('gp_histogram', folder), stream(LOAD, 5.0, seed=7))[-1]
    regression = watched['gp_bayes'][1][-1]
    away = np.abs(histogram.mean - regression.mean) / regression.std
    # The inertia follows by conditional steps, three at a time.
    assert (away[:4] < 0.2).all() and (away[4:] < 0.8).all()
    np.testing.assert_allclose(histogram.std[:4], regression.std[:4], rtol=0.15)
    np.testing.assert_allclose(histogram.std[4:], regression.std[4:], rtol=0.3)


def test_e6_3_the_index_follows_the_data(folder):
    made = pipeline('gp_histogram', folder)
    stds, lattices = [], []
    for m in stream(LOAD, 3.0, seed=7):
        estimate = made.joint_state(m.stamp, m.names, m.position, m.velocity, m.effort)
        if estimate is not None:
            assert 0.0 < made.reliability['largest probability'] < 1.0
            assert 0.0 < made.reliability['entropy [nat]'] <= 4 * np.log(7) + 1e-9
            stds.append(estimate.std[0])
            best = [made.reliability[f'most probable {name}']
                    for name in ('mass [kg]', 'x [m]', 'y [m]', 'z [m]')]
            lattices.append((best - estimate.mean[:4]) / estimate.std[:4])
    assert stds[-1] < 0.05 * stds[0]
    assert (np.abs(lattices[-1]) < 2.0).all()


def test_e6_4_the_learned_functions_doubt_is_told(folder):
    """About what it usually is along a motion like those it learned from; larger on a hot arm."""
    doubts = {}
    for celsius in (25.0, 80.0):
        made = warm(pipeline('gp_bayes', folder), celsius)
        (name, before), = made.reliability.items()
        feed(made, stream(LOAD, 2.0, seed=7))
        doubts[celsius] = made.reliability[name]
        assert before == 0.0
    assert 0.3 < doubts[25.0] < 3.0 and doubts[80.0] > 1.5 * doubts[25.0]


def test_e2_7_searches_find_the_peak_of_the_same_density(folder, watched, monkeypatch):
    wanted = watched['gp_bayes'][1][-1]
    monkeypatch.setattr(GpSwarm, 'STEPS', 20)
    for name in ('gp_evolution', 'gp_annealing', 'gp_swarm'):
        made = pipeline(name, folder)
        found = feed(made, stream(LOAD, 5.0, seed=7))[-1]
        assert (np.abs(found.mean - wanted.mean)[:4] < 4.0 * wanted.std[:4]).all(), name
        # The last search lies up to half a second back: one more sees all there is, and yet
        # another makes no step any more.
        for _ in range(2):
            made.method._next = 0.0
            made.method.settle()
        found = made.method.belief()
        std = np.sqrt(np.diag(found.covariance))
        assert (np.abs(found.mean - wanted.mean)[:4] < 0.5 * wanted.std[:4]).all(), name
        np.testing.assert_allclose(std[:4], wanted.std[:4], rtol=0.15)


@pytest.mark.parametrize('name', ['gp_swarm', 'gp_evolution', 'gp_annealing'])
def test_e2_7_a_search_ends_at_the_optimum_of_a_known_cost(name, folder):
    method = pipeline(name, folder).method
    goal = np.array([0.3, -0.2, 0.05, 0.1])
    stiff = np.array([30.0, 30.0, 20.0, 10.0])

    def cost(u):
        return (stiff * (u - goal) ** 2).sum(-1)
    first, second = (method._search(cost) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert cost(first) < 0.2 and np.abs(first - goal).max() < 0.15


def test_e2_7_a_search_that_ended_short_goes_on_and_says_so(folder, monkeypatch):
    made, asked, right = pipeline('gp_evolution', folder), [], GpEvolution._search

    def short(self, cost):
        """Search, but go only a third of the way the first times."""
        asked.append(cost)
        return right(self, cost) * (0.3 if len(asked) <= 8 else 1.0)

    monkeypatch.setattr(GpEvolution, '_search', short)
    messages = stream(LOAD, 8.0, seed=7)
    truth, away = LOAD.to_message(), []
    for message in messages:
        for found in feed(made, [message]):
            away.append(np.abs(found.mean - truth)[:4] / found.std[:4])
    assert len(asked) > 14 and np.max(away) < 4.0
    assert abs(found.mean[0] - LOAD.mass) < 0.05


@pytest.mark.parametrize('name', ['gp_bayes', 'gp_histogram', 'gp_evolution'])
def test_a_changed_load_is_found_anew(name, folder):
    made = pipeline(name, folder)
    found = feed(made, stream(block(0.5), 6.0, seed=3, change=(3.0, block(3.0))))
    assert made.method.changes == 1
    if name != 'gp_bayes':
        # What the motion filter still shows of the old load does not count beside `bayes` either.
        assert made.method._counted.last_change == made.method.last_change
    assert abs(found[-1].mean[0] - 3.0) < 0.15


@pytest.mark.parametrize('name', ['gp_histogram', 'gp_evolution'])
def test_tare_and_reset(name, folder):
    made = pipeline(name, folder)
    feed(made, stream(LOAD, 4.0, seed=9))
    made.tare(made.last_stamp)
    assert made.method.tared[0] == pytest.approx(2.0, abs=0.1)
    after = feed(made, [m for m in stream(LOAD, 7.0, seed=7) if m.stamp > 104.0])[-1]
    assert abs(after.mean[0]) < max(4.0 * after.std[0], 0.15)
    made.reset()
    assert made.method.belief().covariance[0, 0] > 0.5


@pytest.mark.parametrize('name', sorted(ON_DIFFERENCE))
def test_without_a_learned_difference_the_command_to_run_is_told(name):
    follower = ModelFollower(exact_model('four'))
    with pytest.raises(ConfigurationError, match='hand_load learn-gp'):
        build_method(exact_model('four'), follower.uncertainties, name)


def test_e2_7_the_swarm_is_loaded_before_the_arm_moves(folder):
    """Loading takes two seconds, in which a node hears nothing."""
    code = ('import sys\n'
            'from gp_helpers import pipeline\n'
            f'pipeline("gp_swarm", {str(folder)!r})\n'
            'print("evox.workflows" in sys.modules)')
    done = subprocess.run([sys.executable, '-c', code], cwd=ROOT / 'test', text=True,
                          env={**os.environ, 'PYTHONPATH': f'{ROOT}:{ROOT / "test"}'},
                          capture_output=True, check=True)
    assert done.stdout.split()[-1] == 'True'


def test_e2_5_the_command_learns_with_a_known_load_and_estimates(tmp_path, capsys):
    write_model(tmp_path / 'model.yaml', model())
    write_load_file(tmp_path / 'known.yaml', block(1.0))
    for run, load in (('known', block(1.0)), ('run', LOAD)):
        with RecordingWriter(tmp_path / run) as writer:
            for sample in recording_of(stream(load, 5.0, 4), model().robot.joints).samples:
                writer.write(sample)
    paths = {name: str(tmp_path / name) for name in ('known', 'run', 'out', 'model.yaml')}
    learn = ['learn-gp', paths['known'], '--model', paths['model.yaml'], '--out', paths['out']]
    # What is carried while learning must be told.
    assert main(learn) == 2 and '--load' in capsys.readouterr().err
    assert main([*learn, '--load', str(tmp_path / 'known.yaml'), '--inputs', 'velocity']) == 0
    out = str(tmp_path / 'e.json')
    assert main(['estimate', paths['run'], '--model', paths['model.yaml'], '--method',
                 'gp_bayes', '--learned', paths['out'], '--out', out]) == 0
    # What was carried while learning is not learned as the arm's.
    told = json.loads((tmp_path / 'e.json').read_text('utf-8'))
    assert abs(told['mass']['mean'] - LOAD.mass) < 0.1 and told['status'] == 'DETERMINED', told
    assert main([*learn, '--load', 'none', '--function', 'magic']) == 2
    assert 'neural_process' in capsys.readouterr().err
