"""Identification finds the parameters of an arm made of the torque model itself."""

from dataclasses import replace
import re

from core_helpers import block, exact_model, four_axes, messages, recording_of
from effect_helpers import DT, waves
import numpy as np
import pytest

from hand_load_estimator.cli import main
from hand_load_estimator.effects import DEFAULT_EFFECTS, EFFECTS, EffectInput
from hand_load_estimator.effects.own_travel import BOTH
from hand_load_estimator.errors import ConfigurationError, RecordingError
from hand_load_estimator.files.load_file import write_load_file
from hand_load_estimator.identification.evidence import Evidence, prepare
from hand_load_estimator.identification.identify import declare, identify, nominal_model, prior
from hand_load_estimator.identification.regression_system import posterior_of, System
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.recording import (JointSample, read_recording, Recording,
                                           RecordingWriter)
from hand_load_estimator.residual.add import identified_again
from hand_load_estimator.stream.joint_stream import motion_of
from hand_load_estimator.torque.columns import (ColumnLayout, effect_slices, EffectUse,
                                                torque_columns)
from hand_load_estimator.torque.contact_level import contact_level
from hand_load_estimator.torque.model_file import read_model, write_model
from hand_load_estimator.torque.motion_inputs import motion_input

NAMES = ('link_inertia', 'rotor_inertia', 'coulomb_friction', 'viscous_friction',
         'stribeck_friction', 'presliding_hysteresis', 'temperature_dependent_viscous_friction',
         'torque_offset')
TRUE_SHAPE = {'stribeck_velocity': 0.12, 'presliding_distance': 1.5e-3}


class Made:
    """An arm whose parameters were drawn from identification's own prior."""

    def __init__(self, robot, seed=1, density=None, recordings=4, seconds=30.0, names=NAMES,
                 plastic=BOTH):
        rng = np.random.default_rng(seed)
        self.robot = robot
        shape = TRUE_SHAPE | {'plastic': plastic}
        self.uses = tuple(EffectUse(n, j, {s.name: shape.get(s.name, s.default)
                                           for s in EFFECTS[n].shapes})
                          for j in range(robot.n) for n in names if n in EFFECTS)
        mean, covariance = prior(robot, self.uses, 'link_inertia' in names)
        self.x = mean + 0.5 * np.sqrt(np.diag(covariance)) * rng.normal(size=len(mean))
        for use, where in effect_slices(robot.n, self.uses):
            if use.name == 'coulomb_friction':
                self.x[where.start] = 0.04 * robot.limits.torque[use.joint]
            if use.name == 'stribeck_friction':
                self.x[where.start] = 0.03 * robot.limits.torque[use.joint]
        self.density = density or (4e-3 * robot.limits.torque) ** 2 * DT
        distance = np.full(robot.n, TRUE_SHAPE['presliding_distance'])
        self.evidence, turning = [], np.full(robot.n, plastic)
        for k in range(recordings):
            # Each temperature twice: leaving one recording out must not extrapolate.
            motion = waves(robot, rng, seconds, 15.0 + 20.0 * (k % 2))
            layout = ColumnLayout(robot.n, self.uses)
            x, _ = motion_input(robot, motion, distance, turning,
                                contact_level(robot, self.uses, self.x))
            columns = torque_columns(robot, layout, x)
            noise = rng.normal(size=motion.q.shape) * np.sqrt(self.density / DT)
            self.evidence.append(Evidence(f'run {k}', motion, columns @ self.x + noise))


@pytest.fixture(scope='module')
def made():
    return Made(four_axes())


@pytest.fixture(scope='module')
def found(made):
    return identify(made.robot, made.evidence, list(NAMES))


def test_parameters_are_found_within_their_stated_deviations(made, found):
    """e^T S^-1 e of a right answer is chi-square; identification states its noise a bit wide."""
    assert [u.name for u in found.uses] == [u.name for u in made.uses]
    error = found.mean - made.x
    free = np.flatnonzero(np.diag(found.covariance) > 0.0)
    covariance = found.covariance[np.ix_(free, free)]
    scale = np.sqrt(np.diag(covariance))
    distance = (error[free] / scale) @ np.linalg.solve(covariance / np.outer(scale, scale),
                                                       error[free] / scale)
    assert 0.2 < distance / len(free) < 1.3
    assert (np.abs(error[free]) < 4.5 * scale).all()


def test_e7_1_the_best_parameters_are_those_of_equation_11(made):
    """M_nom + (K^T K + W)^-1 K^T (Y - K M_nom): K holds columns of links and of friction."""
    mean, covariance = prior(made.robot, made.uses, True)
    system = System(made.robot, made.uses, made.evidence, mean)
    weights = system.weights(made.density, np.zeros(made.robot.n))
    got, posterior = system.solve(mean, covariance, weights)
    root = np.sqrt(weights)[:, :, None]
    free = np.flatnonzero(np.diag(covariance) > 0.0)
    scale = np.sqrt(np.diag(covariance)[free])
    k = (root * system.columns[:, :, free]).reshape(-1, len(free)) * scale
    y = (root[:, :, 0] * (system.torque - system.columns @ mean)).ravel()
    wanted = np.linalg.solve(k.T @ k + np.eye(len(free)), k.T @ y)
    np.testing.assert_allclose((got - mean)[free] / scale, wanted, atol=1e-6)
    np.testing.assert_allclose(np.delete(got, free), np.delete(mean, free))
    nothing = system.solve(mean, covariance, 0.0 * weights)
    np.testing.assert_allclose(nothing[0], mean)
    assert (np.diag(posterior) <= np.diag(nothing[1]) + 1e-12).all()


def test_e7_1_what_is_known_of_a_sum_stays_known():
    """Two parameters of which hardly more than the sum is known; new data tell the first only."""
    covariance = np.array([[1.0, -0.9999, 0.0], [-0.9999, 1.0, 0.0], [0.0, 0.0, 0.0]])
    told = np.array([[400.0, 0.0], [0.0, 0.0]]), np.array([200.0, 0.0])
    x, posterior = posterior_of(np.array([1.0, 2.0, 5.0]), covariance, told)
    wanted = np.linalg.inv(np.linalg.inv(covariance[:2, :2]) + told[0])
    np.testing.assert_allclose(posterior[:2, :2], wanted, rtol=1e-6)
    np.testing.assert_allclose(x, [*([1.0, 2.0] + wanted @ told[1]), 5.0])
    assert x[0] + x[1] == pytest.approx(3.0, abs=1e-3)
    assert not posterior[2].any() and not posterior[:, 2].any()


def test_stated_deviations_are_small_where_it_matters(made, found):
    """A wide answer is easily right; friction and torque must be known well, too."""
    std = np.sqrt(np.diag(found.covariance))
    for use, where in found.slices():
        if use.name in ('coulomb_friction', 'viscous_friction'):
            assert std[where.start] < 0.2 * 0.04 * made.robot.limits.torque[use.joint]
    rng, n = np.random.default_rng(5), made.robot.n
    q, v, a = rng.uniform(-1, 1, (3, 200, n))
    columns = torque_columns(made.robot, found.layout, EffectInput(
        q, v, a, np.zeros_like(q), np.sign(v)))
    off = columns @ (found.mean - made.x)
    stated = np.sqrt(np.einsum('knp,pq,knq->kn', columns, found.covariance, columns))
    assert np.sqrt(np.mean(off ** 2, axis=0) / np.mean(stated ** 2, axis=0)).max() < 1.6
    nominal, _ = prior(made.robot, found.uses, True)
    before = columns @ (nominal - made.x)
    assert (np.std(off, axis=0) < 0.05 * np.std(before, axis=0)).all()


def test_shapes_are_found(found):
    shapes = {name: [u.shape[name] for u in found.uses if name in u.shape]
              for name in TRUE_SHAPE}
    np.testing.assert_allclose(shapes['presliding_distance'], 1.5e-3, rtol=0.05)
    assert all(u.shape['plastic'] == BOTH for u in found.uses
               if u.name == 'presliding_hysteresis')
    assert shapes['stribeck_velocity'].count(0.12) >= 3


def test_the_noise_is_found(made, found):
    """The low-frequency density is the largest of four estimates, so it may only be wide."""
    ratio = found.residuals.intensity / made.density
    assert (0.9 < ratio).all() and (ratio < 1.8).all()
    rms = np.sqrt(made.density / DT)
    np.testing.assert_allclose(found.noise, rms, rtol=0.1)


def test_nothing_drifts_where_nothing_drifts(made, found):
    assert (found.residuals.drift[:, 0] < 0.05 * np.sqrt(made.density / DT)).all()


def with_offsets(made):
    """Return Evidence of an arm with another offset in every recording, and their size (n,)."""
    rng, size = np.random.default_rng(3), 0.01 * made.robot.limits.torque
    offsets = size * rng.choice([-1.0, 1.0], (4, 4))
    return [Evidence(e.name, e.motion, e.torque + offsets[k])
            for k, e in enumerate(made.evidence)], size


def test_what_changes_between_recordings_is_drift(made):
    """An offset of another size in every recording is found as such, not as noise."""
    evidence, size = with_offsets(made)
    drift = identify(made.robot, evidence, list(NAMES)).residuals.drift
    assert (drift[:, 0] > 0.5 * size).all() and (drift[:, 0] < 2.5 * size).all()


def test_more_drift_in_new_recordings_is_stated(made, found):
    """`diagnose` of recordings that the model does not know keeps the larger of both."""
    evidence, size = with_offsets(made)
    again = identified_again(found, made.uses, evidence, set(), set()).residuals.drift
    assert (again >= found.residuals.drift).all() and (again[:, 0] > 0.5 * size).all()


def test_what_it_came_from_is_kept(found):
    assert found.recording_names == ['run 0', 'run 1', 'run 2', 'run 3']
    assert found.temperatures == (15.0, 35.0) and found.links_declared


def test_a_single_recording_is_enough(made):
    model = identify(made.robot, made.evidence[:1], list(NAMES))
    assert np.isfinite(model.mean).all() and (model.noise > 0.0).all()


def test_without_temperatures_their_effects_are_left_out(made):
    blind = [Evidence(e.name, replace(e.motion, temperature=np.full(e.motion.q.shape, np.nan)),
                      e.torque) for e in made.evidence[1:2]]
    model = identify(made.robot, blind)
    assert model.temperatures is None
    assert not any('temperature' in u.name for u in model.uses)
    assert {'coulomb_friction', 'viscous_friction'} <= {u.name for u in model.uses}


def test_only_declared_effects_are_in_the_model(made):
    model = identify(made.robot, made.evidence[:1], ['coulomb_friction'])
    assert {u.name for u in model.uses} == {'coulomb_friction'} and not model.links_declared
    np.testing.assert_array_equal(model.mean[:40], made.robot.nominal_links)
    assert not model.covariance[:40].any()


def test_an_unknown_effect_is_refused(made):
    with pytest.raises(ConfigurationError, match='--effects.*sticktion.*coulomb_friction'):
        identify(made.robot, made.evidence, ['coulomb_friction', 'sticktion'])


def test_too_little_motion_is_refused(made):
    robot, motion = made.robot, made.evidence[0].motion
    still = replace(motion, v=np.zeros_like(motion.v))
    short = motion.part(slice(100))
    for bad in (still, short):
        torque = np.zeros_like(bad.q)
        with pytest.raises(RecordingError, match='my run.*of motion.*at least 3 s'):
            identify(robot, [Evidence('my run', bad, torque)], list(NAMES))


def test_a_sensor_behind_the_gear_sees_no_friction_and_no_rotor():
    robot = four_axes(effort={'kind': 'link_torque', 'includes_configured_load': False})
    uses, links = declare(robot, None, np.ones(4, dtype=bool))
    assert links and {u.name for u in uses} == {'torque_offset'}
    plain = Made(robot, names=('link_inertia', 'torque_offset'), recordings=2)
    model = identify(robot, plain.evidence)
    assert (model.friction_level() == 0.0).all()
    np.testing.assert_allclose(model.noise, np.sqrt(plain.density / DT), rtol=0.1)


def test_every_effect_by_default():
    uses, links = declare(four_axes(), None, np.ones(4, dtype=bool))
    assert links and {u.name for u in uses} == set(DEFAULT_EFFECTS) - {'link_inertia'}
    assert len(uses) == 4 * (len(DEFAULT_EFFECTS) - 1)


def test_a_nominal_model_is_the_robot_file():
    robot = four_axes()
    model = nominal_model(robot, np.full(4, 0.01))
    q = np.array([0.1, -0.4, 0.7, 0.2])
    np.testing.assert_allclose(model.torque(q, q, q), robot.rigid_torque(q, q, q))


# The command, with recordings.

def record(path, load, seed=1, velocity=True, load_file=None):
    """Write a 12 s recording of the exact four-axis model carrying a load."""
    model = exact_model('four')
    stream = messages(model, load, 12.0, seed=seed, size=1.2)
    recording = recording_of(stream, model.robot.joints)
    if not velocity:
        recording = Recording('', [JointSample(s.stamp, s.names, s.position, np.array([]),
                                               s.effort) if isinstance(s, JointSample) else s
                                   for s in recording.samples])
    with RecordingWriter(path) as writer:
        for sample in recording.samples:
            writer.write(sample)
    if load_file is not None:
        write_load_file(path / 'load.yaml', load_file)
    return str(path)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a robot file and recordings with and without a load."""
    import yaml
    out = tmp_path_factory.mktemp('identify')
    (out / 'arm.yaml').write_text(yaml.safe_dump(four_axes().file.content))
    record(out / 'empty', LoadParameters(), load_file=LoadParameters())
    record(out / 'loaded', block(2.0), load_file=block(2.0))
    record(out / 'unknown', LoadParameters())
    return out


def identified(folder, *arguments):
    """Run the command; return (status, model or None)."""
    out = folder / 'model.yaml'
    out.unlink(missing_ok=True)
    status = main(['identify', *arguments, '--robot', str(folder / 'arm.yaml'),
                   '--out', str(out)])
    return status, read_model(out) if out.exists() else None


@pytest.mark.parametrize('name', ['magic', 'torque_ripple'])
def test_effects_are_judged_before_recordings_are_read(folder, capsys, name):
    assert identified(folder, 'no_recording', '--effects', name) == (2, None)
    said = capsys.readouterr().err
    assert name in said and 'no_recording' not in said


def test_a_known_load_gives_the_same_model_as_none(folder):
    effects = '--effects=coulomb_friction,viscous_friction,presliding_hysteresis,torque_offset'
    (one, empty), (two, loaded) = (identified(folder, str(folder / run), effects)
                                   for run in ('empty', 'loaded'))
    assert one == two == 0
    deviation = np.sqrt(np.diag(empty.covariance) + np.diag(loaded.covariance))[40:]
    assert (np.abs(empty.mean - loaded.mean)[40:] < 4.0 * deviation).all()
    _, ignored = identified(folder, str(folder / 'loaded'), effects, '--load', 'none')
    assert (np.abs(empty.mean - ignored.mean)[40:] > 8.0 * deviation).any()


def test_a_model_is_identified_again_with_what_a_diagnosis_added(folder, capsys):
    """No list of effects can declare a ripple, whose period only a residual tells."""
    _, plain = identified(folder, str(folder / 'empty'),
                          '--effects=coulomb_friction,viscous_friction')
    ripple = EffectUse('torque_ripple', 1, {'periods': 12.5})
    diagnosed = identified_again(plain, (*plain.uses, ripple), [evidence_of(folder / 'empty')])
    old, out = folder / 'diagnosed.yaml', folder / 'again.yaml'
    write_model(old, diagnosed)
    arguments = ['identify', str(folder / 'loaded'), '--out', str(out), '--model', str(old)]
    assert main(arguments) == 0
    again = read_model(out)
    assert again.uses == read_model(old).uses
    assert (again.mean != diagnosed.mean).any()
    assert [mark.name for mark in again.recordings] == ['empty', 'loaded']
    assert main([*arguments, '--effects', 'coulomb_friction']) == 2
    assert 'does not go with --model' in capsys.readouterr().err


def evidence_of(path):
    """Return the Evidence of a recording of the four-axes arm."""
    recording = read_recording(path)
    motion, _ = motion_of(four_axes(), recording)
    return prepare(four_axes(), path.name, motion, recording.load, recording)


def test_repeated_motion_is_told(folder, capsys):
    effects = '--effects=coulomb_friction,viscous_friction'
    identified(folder, str(folder / 'empty'), effects)
    assert 'repeats what was shown' not in capsys.readouterr().err
    # The loaded run is the same motion.
    identified(folder, str(folder / 'empty'), str(folder / 'loaded'), effects)
    told = re.search(r'(\d+) % of the motion repeats', capsys.readouterr().err)
    assert 40 <= int(told[1]) <= 55


def test_what_the_load_argument_says_goes_before_load_yaml(folder):
    write_load_file(folder / 'two.yaml', block(2.0))
    effects = '--effects=coulomb_friction,viscous_friction'
    _, own = identified(folder, str(folder / 'loaded'), effects)
    _, told = identified(folder, str(folder / 'loaded'), effects, '--load',
                         str(folder / 'two.yaml'))
    np.testing.assert_array_equal(own.mean, told.mean)


@pytest.mark.parametrize('arguments, words', [
    (['unknown'], ['unknown', 'does not say its load', '--load']),
    (['nowhere'], ['nowhere']), (['empty', '--effects', 'magic'], ['magic', 'coulomb_friction']),
    (['empty', '--effects', ''], ['--effects', 'coulomb_friction']),
    (['empty', '--load', 'nowhere.yaml'], ['--load', 'nowhere.yaml']),
    (['half'], ['half', 'com']),
    # The same half-known load, told on the command line, is no better known.
    (['loaded', '--load', 'half.yaml'], ['half.yaml', 'com'])])
def test_wrong_input_ends_with_two_and_one_line(folder, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(folder)
    (folder / 'half.yaml').write_text('mass: 2.0\n')
    if not (folder / 'half').exists():
        record(folder / 'half', block(2.0))
        (folder / 'half' / 'load.yaml').write_text('mass: 2.0\n')
    status, model = identified(folder, *arguments)
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert status == 2 and model is None
    assert said.startswith('hand_load identify: ') and all(word in said for word in words)


def test_temperature_and_counts_come_from_the_recording(folder):
    from hand_load_estimator.recording import read_recording
    motion, rejected = motion_of(four_axes(), read_recording(folder / 'empty'))
    assert not rejected and (motion.temperature == 25.0).all()
    assert 550 < len(motion.stamp) < 620


def remade(robot, made):
    """Return the TorqueModel that `diagnose` makes of the recordings of an identified one."""
    return identified_again(identify(robot, made.evidence, NAMES), made.uses, made.evidence,
                            set(), set())


@pytest.mark.parametrize('recordings, seconds', [(2, 10.0), (4, 10.0), (4, 30.0)])
def test_the_density_is_that_of_the_noise_however_little_is_recorded(recordings, seconds):
    """Of two, each of its own temperature, one foretells the other 3 to 170 times worse."""
    robot = four_axes()
    made = Made(robot, recordings=recordings, seconds=seconds)
    for model in (identify(robot, made.evidence, NAMES), remade(robot, made)):
        ratio = model.residuals.intensity / made.density
        assert (ratio > 0.8).all() and (ratio < 1.6).all()


def test_what_recordings_left_out_show_is_stated(monkeypatch):
    robot, shown, drift = four_axes(), np.array([4.0, 3.0, 2.0, 1.0]), np.full((4, 3), 0.7)
    made = Made(robot, recordings=2, seconds=10.0)
    for module in ('identification.identify', 'residual.add'):
        monkeypatch.setattr(f'hand_load_estimator.{module}.noise_left_out',
                            lambda *_: (shown, drift))
    for model in (identify(robot, made.evidence, NAMES), remade(robot, made)):
        np.testing.assert_array_equal(model.residuals.intensity, shown)
        np.testing.assert_array_equal(model.residuals.drift, drift)
