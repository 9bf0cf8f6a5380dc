"""Networks straight to the load: rows E1.3, E1.4, E1.5, E1.6, E6.1 and E6.2 of the reference."""

import json

from core_helpers import block, exact_model, feed, four_axes, messages
from direct_helpers import artefact_of, design_of, inputs, network_of, pipeline_with
import numpy as np
import pytest
from safetensors.torch import save_file
import torch

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.estimators.load_prior import load_prior
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.learning.direct_artefact import read_direct_artefact
from hand_load_estimator.learning.direct_calibration import direct_answers
from hand_load_estimator.learning.direct_design import design_for, NETWORKS
from hand_load_estimator.learning.direct_network import build_network, Judge
from hand_load_estimator.learning.direct_shards import load_torque, make_direct_shard
from hand_load_estimator.learning.direct_training import DirectRecipe, Loss
from hand_load_estimator.learning.first_moments import (LABEL_STD, message_of,
                                                        message_prior, moments_prior)
from hand_load_estimator.learning.sequences import SequenceMaker
from hand_load_estimator.learning.stated_factors import calibrated
from hand_load_estimator.learning.stated_intervals import calibrate_stated, factors_of
from hand_load_estimator.load import MESSAGE_ORDER
from hand_load_estimator.robot import load_robot

RECURRENT = ('lstm_direct', 'gru', 'elman', 'jordan')


@pytest.fixture(scope='module')
def model():
    return exact_model('four', doubt=0.02)


@pytest.fixture(scope='module')
def robot(model):
    return model.robot


@pytest.fixture(scope='module')
def shard(model, robot):
    return make_direct_shard(SequenceMaker(model), robot, range(6))


@pytest.mark.parametrize('name', NETWORKS)
def test_a_new_network_answers_the_prior(robot, name):
    prior = load_prior(robot)
    network = build_network(robot, design_of(robot, name))
    with torch.no_grad():
        mean, std, _ = network(inputs(robot))
    assert mean.shape == std.shape == (2, 40, 10)
    for said, known in zip((mean, std), moments_prior(prior)):
        np.testing.assert_allclose(said, np.broadcast_to(known, (2, 40, 10)), rtol=1e-5)
    mean, std, _ = Judge(robot, network)(inputs(robot))
    np.testing.assert_allclose(mean[..., :4], np.broadcast_to(prior.mean[:4], (2, 40, 4)),
                               rtol=1e-4)
    if name != 'dropout':   # Copies that say nothing do not scatter.
        assert (std[..., 1:4].numpy() > 0.8 * prior.std[1:4]).all()


@pytest.mark.parametrize('name', RECURRENT)
def test_E1_3_24_inputs_of_six_axes_with_temperatures_ten_outputs(name):
    """theta, theta', theta'', difference of six joints are 24; temperatures and a flag follow."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    network = network_of(robot, design_of(robot, name))
    x = inputs(robot)
    assert x.shape[-1] == 4 * 6 + 6 + 1 == 31
    with torch.no_grad():
        mean, _, _ = network(x)
        for column in range(30):
            other = x.clone()
            other[:, :, column] += 0.5
            assert (network(other)[0] - mean).abs().max() > 1e-6, column
    assert mean.shape[-1] == 10


@pytest.mark.parametrize('name', [name for name in RECURRENT if name != 'jordan'])
def test_E1_3_what_was_gathered_goes_through_a_layer_before_the_answer(tmp_path, robot, name):
    design = design_for(robot, name)
    assert design.head_layers == 1 and design_for(robot, 'feedforward').head_layers == 0
    bent = network_of(robot, design).between
    with torch.no_grad():
        one, two = torch.rand(2, 3, design.hidden)
        assert (bent(one + two) - bent(one) - bent(two)).abs().max() > 1e-3
    # Cards from before the layer name none.
    plain = network_of(robot, design_of(robot, name, head_layers=0))
    artefact_of(tmp_path, robot, plain)
    card = json.loads((tmp_path / 'card.json').read_text(encoding='utf-8'))
    del card['recipe']['design']['head_layers']
    (tmp_path / 'card.json').write_text(json.dumps(card), encoding='utf-8')
    again = read_direct_artefact(tmp_path, robot, name).network
    with torch.no_grad():
        assert torch.equal(again(inputs(robot))[0], plain(inputs(robot))[0])


@pytest.mark.parametrize('name, layers', [('lstm_direct', 1), ('lstm_direct', 3), ('gru', 2),
                                          ('elman', 2)])
def test_E1_3_recurrent_with_one_or_more_layers(robot, name, layers):
    """What came long ago still counts, and sample by sample is the same as all at once."""
    network = network_of(robot, design_of(robot, name, layers=layers))
    x = inputs(robot, count=12)
    with torch.no_grad():
        mean, std, _ = network(x)
        assert (network(x[:, 5:])[0][:, -1] - mean[:, -1]).abs().max() > 1e-6
        state, steps = None, []
        for k in range(x.shape[1]):
            *answer, state = network(x[:, k:k + 1], state)
            steps.append(torch.cat(answer, dim=-1))
    np.testing.assert_allclose(torch.cat(steps, dim=1), torch.cat([mean, std], dim=-1), atol=1e-5)
    assert sum('weight_hh' in n for n, _ in network.named_parameters()) == layers


@pytest.mark.parametrize('layers', [1, 3])
def test_E1_3_a_jordan_network_remembers_its_last_answer_and_nothing_else(robot, layers):
    network = network_of(robot, design_of(robot, 'jordan', layers=layers))
    x = inputs(robot, count=12)
    with torch.no_grad():
        mean, std, answer = network(x[:, :11])
        # Mean in the prior's deviations, then e-folds of those.
        np.testing.assert_allclose((mean[:, -1] - network.centre) / network.scale,
                                   answer[:, :10], atol=1e-4)
        np.testing.assert_allclose(torch.log(std[:, -1] / network.scale),
                                   answer[:, 10:].clamp(max=0.5), atol=1e-5)
        behind, _, _ = network(x[:, 11:], answer)
        np.testing.assert_allclose(behind[:, -1], network(x)[0][:, -1], atol=1e-6)
        assert (network(x[:, 11:])[0] - behind).abs().max() > 1e-5
    assert len(network.backbone.cell.behind) == layers - 1


def test_E1_4_feed_forward_reads_a_window_of_fixed_length(robot):
    network = network_of(robot, design_of(robot, 'feedforward', window=8))
    x = inputs(robot)
    with torch.no_grad():
        mean, _, state = network(x)
        # Only the last 8 samples count, all of them.
        np.testing.assert_allclose(network(x[:, -8:])[0][:, -1], mean[:, -1], atol=1e-6)
        for back, counts in ((8, True), (9, False)):
            other = x.clone()
            other[:, -back] += 1.0
            assert (network(other)[0][:, -1] != mean[:, -1]).any() == counts
        again, at, state = [], 0, None
        for size in (1, 3, 20, 16):
            *answer, state = network(x[:, at:at + size], state)
            again.append(answer[0])
            at += size
    np.testing.assert_allclose(torch.cat(again, dim=1), mean, atol=1e-6)


def test_E1_5_joint_subset_reduces_inputs(robot):
    design = design_for(robot, 'gru', joints=('j2', 'j1'))
    assert design.joints == ('j1', 'j2')
    x = inputs(robot, [1, 2])
    assert x.shape[-1] == 5 * 2 + 1
    with torch.no_grad():
        assert network_of(robot, design)(x)[0].shape == (2, 40, 10)


@pytest.mark.parametrize('name', ['gru', 'elman', 'jordan', 'feedforward'])
def test_E1_3_E1_4_layers_units_and_window_are_chosen(robot, name):
    sizes = {'layers': 2, 'hidden': 12, **({'window': 10} if name == 'feedforward' else {})}
    design = design_for(robot, name, **sizes)
    plain = design_for(robot, name, **{**sizes, 'layers': 1})
    count, fewer = (sum(weight.numel() for weight in build_network(robot, d).parameters())
                    for d in (design, plain))
    assert count > fewer and (design.layers, design.hidden) == (2, 12)


@pytest.mark.parametrize('name', NETWORKS)
def test_E1_5_parameters_not_asked_for_keep_the_prior(tmp_path, robot, name):
    design = design_of(robot, name, parameters=('m', 'y'), joints=('j1', 'j2'))
    artefact = artefact_of(tmp_path, robot, network_of(robot, design))
    model = exact_model('four')
    pipeline = pipeline_with(model, artefact)
    prior = pipeline.method.belief()
    last = feed(pipeline, messages(model, block(2.0), 1.5))[-1]
    others = [k for k in range(10) if k not in (0, 2)]
    np.testing.assert_array_equal(last.mean[others], prior.mean[others])
    np.testing.assert_array_equal(np.diag(last.covariance)[others],
                                  np.diag(prior.covariance)[others])
    assert (last.mean[[0, 2]] != prior.mean[[0, 2]]).all()
    assert (np.diag(last.covariance)[[0, 2]] != np.diag(prior.covariance)[[0, 2]]).all()
    assert np.linalg.eigvalsh(last.covariance).min() > 0.0


@pytest.mark.parametrize('parameters, learnt', [
    (('x', 'z'), [0, 1, 3]), (('m', 'x'), [0, 1]), (('m', 'ixx'), [0, 4]), (('iyy',), [7])])
def test_E1_5_a_centre_asks_for_the_mass_that_it_is_a_moment_of(
        tmp_path, robot, parameters, learnt):
    design = design_of(robot, parameters=parameters)
    assert design.learnt == learnt and design.answers == 2 * len(learnt)
    pipeline = pipeline_with(exact_model('four'),
                             artefact_of(tmp_path, robot, network_of(robot, design)))
    prior = pipeline.method.belief()
    last = feed(pipeline, messages(exact_model('four'), block(2.0), 1.5))[-1]
    changed = [MESSAGE_ORDER[k] for k in range(10) if last.mean[k] != prior.mean[k]]
    assert set(changed) == set(parameters)


@pytest.mark.parametrize('wrong', [{'joints': ('j9',)}, {'parameters': ('mass',)},
                                   {'parameters': ()}, {'network': 'magic'}])
def test_E1_5_unknown_names_are_refused(robot, wrong):
    with pytest.raises(ConfigurationError, match='allowed'):
        design_for(robot, **{'network': 'gru', **wrong})


def test_E1_6_the_load_is_corrected_by_the_predicted_torque_error(robot):
    network = network_of(robot, design_of(robot, 'two_network'))
    x, k = inputs(robot), robot.n
    with torch.no_grad():
        first, error, corrected, _ = network.passes(x)
        assert error.shape == (2, 40, k) and error.abs().max() > 1e-4
        left = x.clone()
        left[..., 3 * k:4 * k] -= error
        again = network.load(left)
        np.testing.assert_allclose(corrected[0], again[0], atol=1e-6)
        np.testing.assert_allclose(network(x)[0], corrected[0], atol=1e-6)
        assert (first[0] - corrected[0]).abs().max() > 1e-4
        # Net B sees motion and load, not the difference: through A's load alone it changes.
        network.load.head.weight.zero_()
        other = x.clone()
        other[..., 3 * k:4 * k] += 0.1
        np.testing.assert_allclose(network.passes(other)[1], network.passes(x)[1], atol=1e-6)


def test_E1_6_net_b_learns_the_difference_that_is_not_the_loads(robot, shard):
    difference = shard['error'] + load_torque(shard['columns'], shard['load'].numpy())
    sequence = SequenceMaker(exact_model('four', doubt=0.02)).make(2)
    np.testing.assert_allclose(difference[2], sequence.difference, atol=1e-4)
    network = network_of(robot, design_of(robot, 'two_network'))
    label = shard['error'] / torch.tensor(robot.limits.torque, dtype=torch.float32)
    assert network.error_loss(label, label) == 0.0
    loss = Loss(robot, DirectRecipe(network.design), 1)(network, shard, 0)
    loss.backward()
    assert network.error_head.bias.grad.abs().min() > 0.0


@pytest.mark.parametrize('name, kind, least', [
    *((name, 'kl', 0.02) for name in NETWORKS),
    *((name, 'jensen_shannon', 1e-4) for name in NETWORKS if name != 'dropout')])
def test_E6_1_training_lowers_the_divergence(robot, shard, name, kind, least):
    torch.manual_seed(1)
    network = build_network(robot, design_of(robot, name))
    loss = Loss(robot, DirectRecipe(network.design, divergence=kind), 1)
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-2)
    values = []
    # What dropout is trained with has a deviation that stands still: its mean alone must do it.
    for _ in range(16 if name == 'dropout' else 6):
        # The same step: the same loads, the same masks.
        value = loss(network, shard, 3)
        optimiser.zero_grad()
        value.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimiser.step()
        values.append(value.item())
    assert values[-1] < values[0] - least, values


def test_what_is_known_well_does_not_drown_the_rest(robot):
    """The loss is the divergence; its gradient goes by the deviation stated."""
    network = network_of(robot, design_of(robot))
    loss = Loss(robot, DirectRecipe(network.design), 1)
    mean = network.centre.expand(1, 1, 10).clone().requires_grad_()
    share = torch.full((10,), 0.5)
    share[0] = 0.01
    truth = network.centre + 0.3 * network.scale
    value = loss._divergence(mean, (share * network.scale)[None, None], truth[None], network.scale)
    value.backward()
    gradient = (mean.grad[0, 0] * network.scale).abs()
    # Plain, the divergence of a hundredth of the prior's deviation would pull 2500 times as hard.
    assert gradient[0] / gradient[4] == pytest.approx(0.5 / 0.01, rel=1e-3)
    std = share * network.scale
    plain = 0.5 * ((0.3 * network.scale) ** 2 + torch.tensor(LABEL_STD) ** 2) / std ** 2
    assert value.item() == pytest.approx((plain + torch.log(std)).mean().item(), rel=1e-4)


def test_every_step_draws_other_loads(robot, shard):
    network = network_of(robot, design_of(robot))
    loss = Loss(robot, DirectRecipe(network.design), 1)
    with torch.no_grad():
        one, again, other = (loss(network, shard, step).item() for step in (1, 1, 2))
    assert one == again != other


def test_E6_1_stated_deviations_follow_the_error(robot, shard):
    """A head that knows mass and not place says so."""
    network = network_of(robot, design_of(robot), size=0.0)
    with torch.no_grad():
        network.head.bias[10] = -3.0
        _, std, _ = network(inputs(robot))
    assert (std[..., 0] < 0.06 * network.scale[0]).all()
    assert (std[..., 1:] == network.scale[1:]).all()


def test_E6_2_thinned_networks_give_mean_and_index(robot):
    network = network_of(robot, design_of(robot, 'dropout', thinned=0.3))
    x = inputs(robot)
    mean, std, _ = Judge(robot, network)(x)
    masks = network.masks(5, torch.Generator().manual_seed(0))
    with torch.no_grad():
        each = torch.stack([network(x, masks=masks[:, k:k + 1].expand(-1, 2, -1))[0]
                            for k in range(5)])
    assert (each.std(dim=0)[:, 5:, 0] > 1e-5).all()
    prior = (part.float() for part in message_prior(load_prior(robot)))
    again = message_of(each.mean(dim=0), each.std(dim=0), *prior)
    np.testing.assert_allclose(mean, again[0], atol=1e-5)
    np.testing.assert_allclose(std, again[1], atol=1e-5)


def test_E6_2_is_seeded(robot):
    network = network_of(robot, design_of(robot, 'dropout', thinned=0.3))
    x = inputs(robot)
    one, again, other = (Judge(robot, network, seed)(x)[1] for seed in (1, 1, 2))
    assert torch.equal(one, again) and not torch.equal(one, other)


def test_E6_1_calibration_gives_95_percent_where_stated_deviations_are_off():
    """Stated ten times too small when small, right when large: intervals come out right."""
    rng = np.random.default_rng(1)

    def draw(count):
        true = np.exp(rng.uniform(-3.0, 1.0, count))
        return true * rng.normal(size=count), true * (0.1 + 0.9 * (np.log(true) + 3.0) / 4.0)

    knots, factors = factors_of(*draw(20000))
    error, std = draw(20000)
    stated = np.ones((20000, 10))
    stated[:, 3] = std
    wide = calibrated(stated, [3], [knots], [factors])
    np.testing.assert_array_equal(np.delete(wide, 3, axis=1), np.delete(stated, 3, axis=1))
    sure = std < np.median(std)
    for part in (sure, ~sure):
        assert 0.94 < (np.abs(error) < 1.96 * wide[:, 3])[part].mean() < 0.96
    assert (np.abs(error) < 1.96 * std)[sure].mean() < 0.7


def test_calibration_asks_the_network_on_shards(tmp_path, robot, shard):
    """Twice as sure is twice the factor, but where the prior helps; sick arms are left out."""
    def factors(sureness, severe):
        changed = {**shard, 'severe': torch.tensor(severe), 'begin': torch.zeros(6)}
        save_file({k: v.contiguous() for k, v in changed.items()}, tmp_path / 's.safetensors')
        network = network_of(robot, design_of(robot), size=0.0)
        with torch.no_grad():
            network.head.bias[10:] = -float(np.log(sureness))
        return calibrate_stated(direct_answers(network, robot, [tmp_path / 's.safetensors']),
                                range(10))[1]

    healthy = [0.0] * 6
    one, two = factors(1.0, healthy), factors(2.0, healthy)
    direct = [0, *range(4, 10)]
    np.testing.assert_allclose(two[direct], 2.0 * one[direct], rtol=1e-4)
    assert (two[1:4] < 2.0 * one[1:4]).all() and (two[1:4] > one[1:4]).all()
    assert (factors(1.0, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0])[0] != factors(1.0, healthy)[0]).any()


def test_all_ten_parameters_are_asked_for_unless_said_otherwise():
    assert design_for(four_axes(), 'gru').parameters == MESSAGE_ORDER
