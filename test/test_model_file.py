"""Torque model files: nothing is lost on the way, edits take effect, nonsense is refused."""

import copy

from core_helpers import exact_model, four_axes
import numpy as np
import pytest
import yaml

from hand_load_estimator.effects import EFFECTS, EffectInput
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.recording_mark import RecordingMark
from hand_load_estimator.load import PRODUCT_ORDER
from hand_load_estimator.torque.columns import EffectUse, parameter_count, torque_columns
from hand_load_estimator.torque.model_file import model_content, read_model, write_model
from hand_load_estimator.torque_model import Residuals, TorqueModel, uncertain_directions

SHORT = ('rotor_inertia', 'coulomb_friction', 'stribeck_friction', 'base_tilt', 'torque_ripple')


def made_up(names):
    """Return a model with effects of these names, correlations and uncommon numbers."""
    robot, rng = four_axes(), np.random.default_rng(1)
    uses = tuple(EffectUse(e.name, j, {s.name: s.grid[j % len(s.grid)] if s.grid else 50.0 + j
                                       for s in e.shapes})
                 for j in range(robot.n) for e in map(EFFECTS.get, names)
                 if not (e.whole_arm and j))
    size = parameter_count(robot.n, uses)
    mean = rng.normal(size=size) * 10.0 ** rng.uniform(-4, 1, size)
    root = rng.normal(size=(size, size)) * 10.0 ** rng.uniform(-6, -2, size)[:, None]
    return TorqueModel(robot, uses, True, mean, root @ root.T, Residuals(
        rng.uniform(0.1, 2.0, 4), rng.uniform(1e-3, 1e-1, 4), rng.uniform(0.0, 0.3, (4, 3)),
        np.array([0.31, np.nan, 0.12, 0.05]), 0.6, np.array([False, True, False, False])),
        (RecordingMark('one'), RecordingMark('two: with a colon', '1234567890123456')),
        (14.5, 51.0), '2026-03-01T14:30:00+01:00')


@pytest.fixture(scope='module')
def model():
    return made_up(EFFECTS)


@pytest.fixture(scope='module')
def file(model, tmp_path_factory):
    path = tmp_path_factory.mktemp('written') / 'model.yaml'
    write_model(path, model)
    return path


@pytest.fixture(scope='module')
def back(file):
    return read_model(file)


@pytest.fixture(scope='module')
def short():
    """Return a model whose file is soon read: with every effect it has 120000 numbers."""
    return made_up(SHORT)


@pytest.fixture
def content(short):
    return copy.deepcopy(model_content(short))


def written(tmp_path, content):
    path = tmp_path / 'edited.yaml'
    path.write_text(yaml.safe_dump(content))
    return path


def columns_of(model, count=50):
    """Return Y (count, n, P) at random motions."""
    rng, shape = np.random.default_rng(2), (50, model.robot.n)
    return torque_columns(model.robot, model.layout, EffectInput(
        rng.uniform(-2, 2, shape), rng.uniform(-1, 1, shape), rng.uniform(-3, 3, shape),
        rng.uniform(-10, 25, shape), rng.uniform(-1, 1, shape)), model.mean, np.full(50, 0.02))


def test_round_trip(model, back):
    np.testing.assert_allclose(back.mean, model.mean, rtol=1e-7)
    assert back.uses == model.uses and back.links_declared == model.links_declared
    assert back.recordings == model.recordings and back.temperatures == model.temperatures
    assert back.diagnosed == model.diagnosed
    for name in ('rmse', 'intensity', 'drift', 'sliding', 'load_share', 'unmoved'):
        np.testing.assert_allclose(getattr(back.residuals, name),
                                   getattr(model.residuals, name), rtol=1e-3)
    np.testing.assert_array_equal(back.robot.nominal_links, model.robot.nominal_links)
    assert back.robot.joints == model.robot.joints


def test_the_covariance_does_the_same_to_the_torque(model, back):
    y = columns_of(model)
    before, after = (np.einsum('knp,pq,knq->kn', y, m.covariance, y) for m in (model, back))
    np.testing.assert_allclose(after, before, rtol=1e-4)
    assert np.linalg.eigvalsh(back.covariance)[0] > -1e-9 * np.linalg.eigvalsh(
        back.covariance)[-1]
    spread = [np.sum((y @ uncertain_directions(m, 12, 0)) ** 2) for m in (model, back)]
    assert spread[1] == pytest.approx(spread[0], rel=1e-3)


def test_writing_what_was_read_changes_nothing(file, back, tmp_path):
    write_model(tmp_path / 'again.yaml', back)
    assert (tmp_path / 'again.yaml').read_text() == file.read_text()


def test_a_file_from_before_diagnoses_were_dated_still_loads(short, content, tmp_path):
    del content['diagnosed'], content['residual']['sliding_residual']
    back = read_model(written(tmp_path, content))
    assert back.diagnosed is None and back.residuals.sliding is None
    np.testing.assert_allclose(back.mean, short.mean, rtol=1e-7)
    again = model_content(back)
    assert again['diagnosed'] is None and 'sliding_residual' not in again['residual']


def test_a_file_from_before_the_load_share_takes_variances_in_full(content, tmp_path):
    del content['residual']['load_share']
    residuals = read_model(written(tmp_path, content)).residuals
    assert residuals.load_share == 1.0
    np.testing.assert_array_equal(residuals.load_intensity, residuals.intensity)


def test_a_model_moves_without_its_robot_file(tmp_path):
    from hand_load_estimator.robot import load_robot
    home = tmp_path / 'home'
    home.mkdir()
    (home / 'arm.urdf').write_text(four_axes().file.content['urdf'])
    (home / 'arm.yaml').write_text(yaml.safe_dump(
        {**four_axes().file.content, 'urdf': 'arm.urdf'}))
    robot = load_robot(home / 'arm.yaml')
    plain = exact_model('four')
    moved = TorqueModel(robot, plain.uses, False, plain.mean, plain.covariance, plain.residuals)
    write_model(home / 'model.yaml', moved)
    (home / 'model.yaml').rename(tmp_path / 'model.yaml')
    for file in ('arm.urdf', 'arm.yaml'):
        (home / file).unlink()
    back = read_model(tmp_path / 'model.yaml')
    q = np.full(4, 0.3)
    np.testing.assert_allclose(back.torque(q, q, q), moved.torque(q, q, q), rtol=1e-6)


def test_a_mean_and_a_std_edited_by_hand_take_effect_and_nothing_else(short, content, tmp_path):
    entry = content['effects'][3]
    use, where = short.slices()[3]
    parameter = entry['parameters'][use.effect.parameters[0][0]]
    parameter['mean'], parameter['std'] = 12.5, 0.75
    content['links']['j2']['mz']['mean'] = 0.125
    back, place = read_model(written(tmp_path, content)), where.start
    changed = short.mean.copy()
    changed[place] = 12.5
    changed[20 + PRODUCT_ORDER.index('mz')] = 0.125
    np.testing.assert_allclose(back.mean, changed, rtol=1e-7)
    std = np.sqrt(np.diag(short.covariance))
    std[place] = 0.75
    np.testing.assert_allclose(np.sqrt(np.diag(back.covariance)), std, rtol=1e-5)
    scale = np.sqrt(np.diag(back.covariance))
    before = np.sqrt(np.diag(short.covariance))
    np.testing.assert_allclose(back.covariance / np.outer(scale, scale),
                               short.covariance / np.outer(before, before), atol=1e-5)


def test_an_effect_for_several_joints_is_one_for_each(content, tmp_path):
    """A person may write one entry for all joints."""
    parameters = {'level': {'mean': 2.0, 'std': 0.1, 'unit': 'Nm'}}
    content['effects'] = [{'name': 'coulomb_friction', 'joints': ['j0', 'j3'],
                           'parameters': parameters}]
    content['correlations'] = []
    back = read_model(written(tmp_path, content))
    np.testing.assert_array_equal(back.friction_level(), [2.0, 0.0, 0.0, 2.0])
    assert np.count_nonzero(back.covariance[40:, 40:]) == 2


def test_numbers_as_people_write_them(content, tmp_path):
    """`1e-3` is a number to a person and, without a dot, a text to YAML 1.1."""
    path = written(tmp_path, content)
    name = f"mean: {content['links']['j0']['m']['mean']}"
    text = path.read_text()
    assert name in text
    path.write_text(text.replace(name, 'mean: 5e-1', 1))
    assert 0.5 in read_model(path).mean


def change(*keys, to):
    """Return an edit that sets (or with DELETE removes) a nested value."""
    def edit(content):
        for key in keys[:-1]:
            content = content[key]
        if to is DELETE:
            del content[keys[-1]]
        else:
            content[keys[-1]] = to
    return edit


DELETE = object()
WRONG = {
    'schema': (change('schema', to='hand_load/torque_model/9'), 'schema'),
    'no schema': (change('schema', to=DELETE), 'schema'),
    'no robot': (change('robot', to=DELETE), 'robot'),
    'robot a text': (change('robot', to='ur10e'), 'robot'),
    'robot with a wrong value': (change('robot', 'gravity', to=[0, 0]), 'gravity'),
    'effects a text': (change('effects', to='friction'), 'effects'),
    'effect unknown': (change('effects', 0, 'name', to='magic'), 'effects[0]: name'),
    'effect a text': (change('effects', 1, to='coulomb_friction'), 'effects[1]'),
    'effect of an unknown joint': (change('effects', 0, 'joints', to=['j7']), 'j7'),
    'effect without parameters': (change('effects', 0, 'parameters', to=DELETE), 'parameters'),
    'effect with a wrong key': (change('effects', 0, 'shpae', to={}), 'shpae'),
    'parameter unknown': (change('effects', 0, 'parameters', 'colour', to={
        'mean': 1.0, 'std': 0.0}), 'colour'),
    'parameter not a number': (change('effects', 1, 'parameters', 'level', 'mean', to='much'),
                               'mean'),
    'std negative': (change('effects', 1, 'parameters', 'level', 'std', to=-1.0), 'std'),
    'std missing': (change('effects', 1, 'parameters', 'level', 'std', to=DELETE), 'std'),
    'no links': (change('links', to=DELETE), 'links'),
    'a link missing': (change('links', 'j1', to=DELETE), 'j1'),
    'a link too many': (change('links', 'j9', to={}), 'j9'),
    'a product missing': (change('links', 'j1', 'Ixy', to=DELETE), 'Ixy'),
    'a product NaN': (change('links', 'j1', 'Ixy', 'mean', to=float('nan')), 'mean'),
    'noise of three': (change('residual', 'torque_noise', to=[1.0, 1.0, 1.0]), 'torque_noise'),
    'noise of nothing': (change('residual', 'torque_noise', to=[0.0] * 4), 'torque_noise'),
    'density zero': (change('residual', 'low_frequency_density', to=[0.0] * 4),
                     'low_frequency_density'),
    'drift of two': (change('residual', 'drift_std', to=[[1.0, 1.0]] * 4), 'drift_std'),
    'drift negative': (change('residual', 'drift_std', to=[[-1.0, 1.0, 1.0]] * 4), 'drift_std'),
    'diagnosed some day': (change('diagnosed', to='on Monday'), 'diagnosed'),
    'diagnosed a number': (change('diagnosed', to=2026), 'diagnosed'),
    'sliding residual of three': (change('residual', 'sliding_residual', to=[1.0, 1.0, None]),
                                  'sliding_residual'),
    'sliding residual negative': (change('residual', 'sliding_residual', to=[-1.0] * 4),
                                  'sliding_residual'),
    'sliding residual a text': (change('residual', 'sliding_residual', to='small'),
                                'sliding_residual'),
    'residual unknown key': (change('residual', 'colour', to=1), 'colour'),
    'temperatures of one': (change('temperatures', to=[20.0]), 'temperatures'),
    'recordings a number': (change('recordings', to=5), 'recordings'),
    'recordings a text': (change('recordings', to='one'), 'recordings'),
    'a recording a number': (change('recordings', to=['one', 5]), 'recordings'),
    'a recording without content': (change('recordings', to=[{'name': 'one'}]),
                                    'recordings[0]: content'),
    'a recording with more': (change('recordings', to=[
        'one', {'name': 'two', 'content': 'ab', 'stamp': 1.0}]), 'stamp'),
    'correlations short': (change('correlations', to=[[]]), 'correlations'),
    'correlations a text': (change('correlations', to='none'), 'correlations'),
    'a correlation a text': (change('correlations', 3, to=[0.0, 0.0, 'x']), 'correlations'),
    'a correlation a number': (change('correlations', 3, to=7), 'correlations'),
    'a correlation of two': (change('correlations', 3, to=[0.0, 0.0, 2.0]), 'correlations'),
    'a correlation NaN': (change('correlations', 3, to=[0.0, 0.0, float('nan')]),
                          'correlations'),
    'a key nobody knows': (change('colour', to='red'), 'colour')}


@pytest.mark.parametrize('case', WRONG)
def test_wrong_model_files_are_refused_with_file_and_key(content, tmp_path, case):
    edit, key = WRONG[case]
    edit(content)
    path = written(tmp_path, content)
    with pytest.raises(ConfigurationError) as caught:
        read_model(path)
    assert key in str(caught.value) and str(path) in str(caught.value)


@pytest.mark.parametrize('number', [1, 2])
def test_a_file_whose_friction_turns_as_before_is_to_be_identified_again(content, tmp_path,
                                                                         number):
    """The same parameters meant another torque."""
    content = {**content, 'schema': f'hand_load/torque_model/{number}'}
    (tmp_path / 'old.yaml').write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigurationError) as refused:
        read_model(tmp_path / 'old.yaml')
    assert 'hand_load identify' in str(refused.value) and 'schema' in str(refused.value)


def test_a_model_file_that_is_not_there(tmp_path):
    with pytest.raises(ConfigurationError, match='model.yaml.*cannot be read'):
        read_model(tmp_path / 'model.yaml')
