"""What is shipped for the default robot is there, fits, and is what it says."""

import json

from core_helpers import CALIBRATED
import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import cases
from hand_load_estimator.benchmark.contestants import our_contestants, SUBSET
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.build import (build_method, build_pipeline,
                                                  shipped_artefact, shipped_difference)
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.estimators.registry import ON_DIFFERENCE
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.learning.artefact import read_artefact
from hand_load_estimator.learning.difference_artefact import read_difference
from hand_load_estimator.learning.direct_artefact import read_direct_artefact
from hand_load_estimator.learning.direct_design import NETWORKS
from hand_load_estimator.load import MESSAGE_ORDER
from hand_load_estimator.robot import load_robot
from hand_load_estimator.torque.model_file import read_model
from hand_load_estimator.torque.model_follower import ModelFollower


def test_the_default_robot_has_a_model_and_an_artefact_that_fit():
    pipeline = build_pipeline('ur10e', 'lstm', None, 'ur10e')
    assert pipeline.method.name == 'lstm'


def test_another_effort_kind_of_the_same_joints_has_no_artefact():
    assert shipped_artefact(load_robot(find_shared('ur10e_current', 'robots'))) is None


def test_the_artefact_is_small_and_its_card_tells_recipe_seed_and_scores():
    robot = load_robot(find_shared('ur10e', 'robots'))
    folder = shipped_artefact(robot)
    assert sum(path.stat().st_size for path in folder.iterdir()) < 5e6
    assert {path.suffix for path in folder.iterdir()} == {'.safetensors', '.json'}
    card = read_artefact(folder, robot).card
    assert card['recipe']['seed'] == 1 and card['seeds']['training'] == seeds.TRAINING.start
    held_out = card['held_out']['coverage_of_95']
    assert set(held_out) == set(MESSAGE_ORDER)
    assert all(0.9 <= share <= 0.99 for share in held_out.values())
    model = read_model(find_shared('ur10e', 'models'))
    assert card['model_recordings'] == model.recording_names


def test_the_shipped_model_has_a_learned_difference_of_its_own():
    model = read_model(find_shared('ur10e', 'models'))
    folder = shipped_difference(model)
    assert sum(path.stat().st_size for path in folder.iterdir()) < 1e6
    card = read_difference(folder, model).card
    assert card['function'] == 'gp' and card['recordings'] == model.recording_names
    for name in ON_DIFFERENCE:
        assert build_pipeline('ur10e', name).method.name == name


def test_e1_5_a_network_of_some_joints_and_parameters_is_shipped_and_never_chosen_for_the_whole():
    robot = load_robot(find_shared('ur10e', 'robots'))
    folder = shipped_artefact(robot, 'gru')
    assert folder.name == 'ur10e_gru'
    subset = read_direct_artefact(folder.with_name('ur10e_gru_subset'), robot, 'gru').card
    design = subset['recipe']['design']
    assert design['joints'] == ['shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint']
    assert design['parameters'] == ['m', 'x', 'y', 'z']
    assert set(subset['held_out']['coverage_of_95']) == set(design['parameters'])


def test_an_artefact_is_chosen_by_its_short_name():
    whole, subset = (build_pipeline('ur10e', 'gru', name).method.state()['weights']
                     for name in (None, 'ur10e_gru_subset'))
    assert (whole != subset).any()
    with pytest.raises(ConfigurationError, match='ur10e_gruu.*neither.*ur10e_gru_subset'):
        build_pipeline('ur10e', 'gru', 'ur10e_gruu')


@pytest.mark.parametrize('network', NETWORKS)
def test_every_direct_network_is_shipped_small_and_calibrated(network):
    """E1.3, E1.4, E1.6, E6.1, E6.2: selectable without training anything."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    folder = shipped_artefact(robot, network)
    assert sum(path.stat().st_size for path in folder.iterdir()) < 2e6
    card = read_direct_artefact(folder, robot, network).card
    assert card['recipe']['design']['parameters'] == list(MESSAGE_ORDER)
    assert card['seeds']['training'] == seeds.TRAINING.start
    # 128 sequences cannot tell a parameter's coverage to better than a few percent.
    held_out = card['held_out']['coverage_of_95']
    assert set(held_out) == set(MESSAGE_ORDER)
    assert 0.92 <= np.mean(list(held_out.values())) <= 0.98
    assert build_pipeline('ur10e', network, None, 'ur10e').method.name == network


@pytest.fixture(scope='module')
def light_and_heavy():
    """Return [(load, MotionSamples)] of 8.8 and 0.8 kg on the arm of the shipped model."""
    robot, out = load_robot(find_shared('ur10e', 'robots')), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, 'DURATION', 5.5)
        for seed in (seeds.DEVELOPMENT_CASES[802], seeds.DEVELOPMENT_CASES[803]):
            case = cases.draw_case(robot, seeds.SHIPPED_MODEL_PLANT, seed)
            out.append((case.load, cases.case_run(robot, case).samples))
    return out


@pytest.mark.parametrize('network', (*NETWORKS, SUBSET))
def test_every_shipped_direct_network_weighs_what_is_held(network, light_and_heavy):
    """
    E1.3 to E1.6, E6.1, E6.2: one load lighter, one heavier than what is expected before.

    An answer that does not depend on the load is far off for one of them.
    """
    model = read_model(find_shared('ur10e', 'models'))
    expected = load_prior(model.robot).mean[0]
    for load, samples in light_and_heavy:
        ((name, contestant),) = our_contestants(model, (network,), None).items()
        assert name == network
        for sample in samples:
            belief = contestant.update(sample)
        assert abs(belief.mean[0] - load.mass) < 0.2 * abs(expected - load.mass)


def test_a_benchmark_runs_calibrated_intervals_where_it_is_asked_to(light_and_heavy):
    model = read_model(find_shared('ur10e', 'models'))
    names = 'bayes', 'bayes_calibrated'
    plain, ours = (racing := our_contestants(model, names, None)).values()
    assert tuple(racing) == names
    for sample in light_and_heavy[0][1]:
        stated, true = (contestant.update(sample) for contestant in (plain, ours))
    np.testing.assert_array_equal(stated.mean[:4], true.mean[:4])
    # A body that can exist is the nearest one in deviations, which are others.
    assert (abs(stated.mean - true.mean) < 0.01 * np.sqrt(stated.covariance.diagonal())).all()
    factors = np.sqrt(true.covariance.diagonal() / stated.covariance.diagonal())
    assert (factors[4:] < 0.95).all(), 'the moments of inertia, which bayes states too wide'


@pytest.mark.parametrize('method', CALIBRATED)
def test_methods_without_a_network_have_calibrated_intervals_to_ask_for(method):
    """They hold about 95 % of draws that they were not made from, and the prior stays."""
    model = read_model(find_shared('ur10e', 'models'))
    folder = find_shared(f'ur10e_{method}_intervals', 'learned')
    held = json.loads((folder / 'card.json').read_text())['held_out']['coverage_of_95']
    assert all(0.92 < share < 0.98 for share in held.values()), held
    size = ModelFollower(model).uncertainties
    plain, ours = (build_method(model, size, method, intervals=chosen).belief().covariance
                   for chosen in (None, str(folder)))
    np.testing.assert_allclose(ours, plain, rtol=1e-6)
