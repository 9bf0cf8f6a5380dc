"""The cost suite: time per sample and per joint state of every method, and memory."""

import subprocess
import sys

from core_helpers import four_axes
import numpy as np
import pytest
from ros_helpers import ROOT

from hand_load_estimator.benchmark import cases, cost
from hand_load_estimator.benchmark.contestants import chosen_methods, cost_of, functions_of
from hand_load_estimator.benchmark.cost_page import cost_blocks
from hand_load_estimator.benchmark.document import to_markdown
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.learning.difference_artefact import PREDICTORS
from hand_load_estimator.motion import MotionSample
from hand_load_estimator.plant import JointEvent
from hand_load_estimator.simulation.simulate_motions import named_motion


def test_the_first_sample_is_no_running_cost():
    assert cost_of([9.0, *[1.0] * 98, 3.0]) == {
        'mean': pytest.approx(101.0 / 99.0), 'p50': 1.0, 'p99': pytest.approx(1.04, abs=0.01)}


def test_cost_is_told_over_one_regressor_call():
    found = {'name': 'bayes', 'cost': {'mean': 3e-4, 'p50': 2e-4, 'p99': 9e-4},
             'regressor': {'mean': 1e-5, 'p50': 1e-5, 'p99': 2e-5},
             'regressor_alone': {'mean': 5e-6, 'p50': 5e-6, 'p99': 6e-6},
             'joint_state': {'mean': 5e-5, 'p50': 4e-5, 'p99': 8e-5}, 'start_mib': 1.0,
             'growth_mib': 0.25}
    slower = {**found, 'name': 'gru', 'regressor': {'mean': 3e-5, 'p50': 2e-5, 'p99': 4e-5}}
    content = cost.cost_scores({'cost_lstm': found, 'cost_gru': slower})
    page = to_markdown(cost_blocks(content))
    assert '| lstm | 300.0 | 200.0 | 900.0 | 5.0 | 10.0 | 60 | 180 | 30 | 90 |' in page
    assert '| gru | 300.0 | 200.0 | 900.0 | 5.0 | 30.0 | 60 | 180 | 10 | 30 |' in page, (
        'its own process counts')
    # A tenth of 300 us beside 50 us at 500 Hz are 40 ms of every second; a twentieth at 1 kHz.
    assert '| lstm | 50.0 | 80.0 | 16 | 4.0 | 65.0 | 13 | 6.5 | +1.0 | +0.2 |' in page
    assert 'joint torque regressor call (whole arm)' in page
    assert '`lstm` has no artefact here and ran as `bayes`' in page


def test_the_undisturbed_call_is_timed_at_every_sample_but_the_warm_up(monkeypatch):
    robot, zero = four_axes(), np.zeros(4)
    samples = [MotionSample(0.02 * k, 0.02, zero, zero, zero, zero, zero, False)
               for k in range(60)]
    timed = []
    monkeypatch.setattr(cost, 'cost_of', timed.append)
    cost.regressor_alone(robot, samples)
    assert len(timed[0]) == 10 and min(timed[0]) > 0.0


def test_every_joint_state_is_timed_and_samples_are_as_before():
    robot = four_axes()
    events = list(cases.motion_events(robot, named_motion('pick_place', robot, 1.0, 0.5, 1)))
    stream = cost.TimedStream(robot)
    samples = list(cases.stream_samples(robot, events, stream))
    assert len(stream.times) == sum(isinstance(event, JointEvent) for event in events) > 100
    assert min(stream.times) > 0.0
    plain = list(cases.stream_samples(robot, events))
    assert len(plain) == len(samples)
    np.testing.assert_array_equal([s.effort for s in plain], [s.effort for s in samples])


@pytest.mark.parametrize('method', ['gp_bayes', 'gru_subset'])
def test_a_method_with_an_artefact_of_its_own_has_its_cost(monkeypatch, method):
    """On the difference, or of the joints, shipped for the model; 50 samples are warm-up."""
    monkeypatch.setattr(cases, 'DURATION', 2.0)
    found = cost.measure_cost('ur10e', method, None)
    assert found['name'] == method
    assert found['cost']['mean'] > found['regressor']['mean'] > 0.0
    assert found['cost']['mean'] > found['regressor_alone']['mean'] > 0.0
    assert found['joint_state']['mean'] > 0.0


def test_e2_6_every_function_of_the_difference_can_be_chosen_and_is_learned():
    assert functions_of(('bayes', 'lstm')) == ()
    assert functions_of(('gp_bayes', 'gp_swarm')) == ('gp',)
    assert functions_of(('gp_bayes_distilled',)) == ('distilled',)
    assert functions_of(('gp_bayes_calibrated', 'bayes_calibrated')) == ('gp',)
    assert functions_of(('gp_bayes_known_load',)) == ('known_load',)
    assert functions_of() == tuple(sorted((*PREDICTORS, 'known_load')))
    with pytest.raises(ConfigurationError, match='--methods.*gp_bayes_neural_process'):
        chosen_methods(('gp_bayes_magic',))


def test_every_method_has_a_cost_job():
    """But for functions of the torque difference of which none is shipped."""
    assert set(cost.cost_jobs('ur10e', None, None)) \
        == {f'cost_{name}' for name in chosen_methods()} \
        - {'cost_gp_bayes_neural_process', 'cost_gp_bayes_distilled',
           'cost_gp_bayes_bayesian_network', 'cost_gp_bayes_known_load'}


def test_resident_memory_is_seen():
    """In a process of its own: here freed memory of other tests may serve again."""
    grown = subprocess.run([sys.executable, '-c', (
        'import numpy as np\n'
        'from hand_load_estimator.benchmark.memory import resident_mib\n'
        'before = resident_mib()\n'
        'held = np.ones(4_000_000)\n'
        'print(resident_mib() - before)')], cwd=ROOT, capture_output=True, text=True, check=True)
    assert 20.0 < float(grown.stdout) < 60.0
