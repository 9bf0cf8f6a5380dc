"""Suites draw what they say, and their extra arms come from URDFs."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator import seeds
from hand_load_estimator.benchmark import arms, suites
from hand_load_estimator.benchmark.cases import case_arguments
from hand_load_estimator.benchmark.suites import (cases_of, recorded_words, ROOM, SUITES,
                                                  UNDECLARED)
from hand_load_estimator.benchmark.wrist_swing import LEAST_ACCELERATION, wrist_swing
from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.plant import Plant
from hand_load_estimator.plant.hidden import EFFECTS
from hand_load_estimator.robot import load_robot

PLANT = seeds.DEVELOPMENT_PLANTS[95]
CASES = seeds.DEVELOPMENT_CASES[900:940]


def drawn(suite, robot):
    return [SUITES[suite].draw(robot, PLANT, seed) for seed in CASES]


def test_the_base_suite_is_what_it_was():
    """200 cases, 25 plants, 8 each in the order of their seeds: results stay comparable."""
    found = cases_of(SUITES['base'])
    assert [plant for plant, _ in found] == list(seeds.BENCHMARK_PLANTS[:25])
    assert [part for _, part in found] == [
        list(seeds.BENCHMARK_CASES[8 * k:8 * k + 8]) for k in range(25)]


@pytest.mark.parametrize(('count', 'plants'), [(None, 10), (4, 1), (30, 8), (2000, 50)])
def test_cases_are_spread_over_plants(count, plants):
    found = cases_of(SUITES['cold'], count)
    every = [seed for _, part in found for seed in part]
    assert len(every) == len(set(every)) == (count or 40)
    assert len(found) <= plants and len({plant for plant, _ in found}) == len(found)
    assert all(part for _, part in found)
    assert len(found) >= 40 or (count or 40) < 2000


def test_development_never_touches_the_benchmarks_seeds():
    for name, suite in SUITES.items():
        for plant, part in cases_of(suite, 20, development=True):
            assert plant in seeds.DEVELOPMENT_PLANTS, name
            assert all(seed in seeds.DEVELOPMENT_CASES for seed in part), name


def test_cold_and_warm_slow_and_fast_are_the_same_cases_but_for_that():
    robot = four_axes()
    for first, second, what, low, high in (('cold', 'warm', 'temperature', 20.0, 40.0),
                                           ('slow', 'fast', 'speed', 0.45, 0.85)):
        pairs = list(zip(drawn(first, robot), drawn(second, robot)))
        for a, b in pairs:
            np.testing.assert_array_equal(a.load.to_message(), b.load.to_message())
            assert getattr(a, what) <= low and high <= getattr(b, what)
        assert len({getattr(a, what) for a, _ in pairs}) == len(CASES)


def test_loads_of_the_inertia_suite_are_heavy_and_wide():
    robot = load_robot(find_shared('ur10e', 'robots'))
    for case in drawn('inertia', robot):
        assert 6.0 <= case.load.mass <= 10.0 and case.load.is_physical()
        # An ellipsoid's half axis a^2 = 5 (second moment along it) / mass.
        i = case.load.inertia
        second = np.linalg.eigvalsh(0.5 * np.trace(i) * np.eye(3) - i)
        across = 2.0 * np.sqrt(5.0 * second / case.load.mass)
        assert (across >= 0.3 - 1e-9).all() and (across <= 0.4 + 1e-9).all()


@pytest.mark.parametrize('seed', range(3))
def test_wrists_swing_inside_all_limits(seed):
    robot = load_robot(find_shared('ur10e', 'robots'))
    motion = wrist_swing(robot, 6.0, np.random.default_rng(seed))
    q, v, a = motion.sample(np.linspace(0.0, 6.0, 1201))
    assert (np.abs(a).max(axis=0)[-3:] >= LEAST_ACCELERATION).all()
    assert (np.abs(a) <= robot.limits.acceleration).all()
    assert (np.abs(v) <= robot.limits.velocity).all()
    assert ((q >= robot.limits.lower) & (q <= robot.limits.upper)).all()
    torque = np.array([robot.rigid_torque(*row, robot.rated_load) for row in zip(q, v, a)])
    assert (np.abs(torque) <= 0.85 * robot.limits.torque).all()
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-12)


def test_wrists_that_cannot_swing_are_refused():
    content = {**four_axes().file.content}
    content['max_acceleration'] = [2.0] * 4
    from hand_load_estimator.robot import robot_from_content
    with pytest.raises(ConfigurationError, match='swings the rated load'):
        wrist_swing(robot_from_content(content, 'slow'), 3.0, np.random.default_rng(0))


def test_undeclared_effects_take_turns_at_strength_two():
    robot = four_axes()
    seed = next(s for s in CASES if UNDECLARED[s % len(UNDECLARED)] == 'torque_offset')
    case = SUITES['undeclared'].draw(robot, PLANT, seed)
    (entry,) = case.hidden
    assert entry['name'] == 'torque_offset' and entry['strength'] == 2.0
    assert len(entry['joints']) == 1
    drawn = {UNDECLARED[s % len(UNDECLARED)] for s in CASES}
    assert drawn == set(EFFECTS) - {'load_change'}


def test_every_effect_has_four_cases_on_four_plants(monkeypatch):
    """Of the cases as drawn; every joint can have every effect, which takes long to find out."""
    monkeypatch.setattr(suites, 'place', lambda robot, case: [{'name': case.hidden[0].name}])
    robot, plants = four_axes(), {}
    for plant, part in cases_of(SUITES['undeclared']):
        for seed in part:
            (entry,) = SUITES['undeclared'].draw(robot, plant, seed).hidden
            plants.setdefault(entry['name'], []).append(plant)
    assert set(plants) == set(EFFECTS) - {'load_change'}
    assert all(len(own) == len(set(own)) == 4 for own in plants.values())


def test_where_no_joint_can_have_an_effect_the_next_one_is_hidden(monkeypatch):
    robot, names = four_axes(), list(UNDECLARED)
    seed = next(s for s in CASES if names[s % len(names)] == 'torque_offset')
    place = suites.place

    def without(refused):
        def placed(robot, case):
            if case.hidden[0].name in refused:
                raise ConfigurationError('plant', 'cannot')
            return place(robot, case)
        return placed

    last = names.index('torque_offset')
    monkeypatch.setattr(suites, 'place', without(names[last:]))
    (entry,) = SUITES['undeclared'].draw(robot, PLANT, seed).hidden
    assert entry['name'] in names[:last]
    monkeypatch.setattr(suites, 'place', without(names))
    with pytest.raises(ConfigurationError, match='no effect so strong'):
        SUITES['undeclared'].draw(robot, PLANT, seed)


# Arms.

def test_an_arms_file_is_the_draft_filled_in(tmp_path, monkeypatch):
    urdf = tmp_path / 'small.urdf'
    urdf.write_text(four_axes().file.urdf)
    own = four_axes()
    monkeypatch.setitem(arms.ARMS, 'small', arms.ExtraArm(
        str(urdf), own.load_frame, 'link_torque', 2.0, 0.1, (5.0,) * 4, 'made up'))
    robot = load_robot(arms.write_arm('small', urdf, tmp_path / 'robots'))
    assert robot.joints == own.joints and robot.effort.kind == 'link_torque'
    assert robot.rated_load.mass == 2.0 and robot.limits.acceleration.tolist() == [5.0] * 4
    assert 'sensors behind the gears' in arms.friction_told(robot)
    assert 'Coulomb' in arms.friction_told(own)


@pytest.mark.parametrize('name', arms.ARMS)
def test_the_extra_arms_can_be_simulated(name, tmp_path):
    from hand_load_estimator.benchmark.cases import simulated
    from hand_load_estimator.simulation.simulate_motions import named_motion
    try:
        urdf = arms.urdf_of(arms.ARMS[name])
    except ConfigurationError:
        pytest.skip(f'{arms.PACKAGE} is not installed')
    robot = load_robot(arms.write_arm(name, urdf, tmp_path))
    assert robot.n == {'ur5': 6}.get(name, 7)
    motion = named_motion('pick_place', robot, 4.0, 1.0, 3)
    samples = simulated(robot, motion, seed=PLANT, load=robot.rated_load)
    assert len(samples) > 50
    assert max(np.abs(s.v).max() for s in samples) > 0.1
    effort = np.array([s.effort for s in samples])
    assert np.isfinite(effort).all() and (np.abs(effort) <= robot.limits.torque).all()


def test_arms_need_their_package(monkeypatch):
    monkeypatch.setattr(arms, 'PACKAGE', 'no-such-package')
    with pytest.raises(ConfigurationError, match='arms needs the package'):
        arms.urdf_of(arms.ARMS['ur5'])


def test_the_recordings_of_a_suites_models_are_told():
    assert recorded_words(SUITES['base']) == '4 recordings of 160 s in all'
    assert recorded_words(SUITES['sparse']) == 'one 20 s recording'


def test_a_warm_arm_in_a_cool_room_is_warmer_than_its_sensors_say():
    """Everywhere else arm, sensors and room have one temperature at the start."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    case = SUITES['room'].draw(robot, 1, 3_000_000)
    assert case.room == ROOM < 30.0 <= case.temperature <= 50.0
    soaked = replace(case, room=None)
    own, same = (Plant(robot, **case_arguments(c)) for c in (case, soaked))
    # Sensors have the same noise in both.
    lag = same.measure_temperatures() - own.measure_temperatures()
    assert (lag >= 0.0).all() and np.median(lag) > 0.3
    assert SUITES['room'].recorded.room == ROOM and SUITES['base'].recorded.room is None
