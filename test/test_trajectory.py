"""Trajectory: interpolation, joining, files."""

import numpy as np
import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.motions.trajectory import (Trajectory, concatenate, hold,
                                                    read_trajectory_csv, write_trajectory_csv)


def wavy(joints=3, knots=9):
    t = np.linspace(0.0, 2.0, knots)[:, None] ** 1.2
    w = np.arange(1, joints + 1)
    return Trajectory(t[:, 0], np.sin(w * t), w * np.cos(w * t), -w ** 2 * np.sin(w * t))


def test_a_quintic_is_reproduced_exactly():
    c = np.random.default_rng(1).normal(size=(6, 2))
    polynomial = [np.polynomial.Polynomial(c[:, j]) for j in range(2)]

    def columns(t, order):
        return np.stack([(p.deriv(order) if order else p)(t) for p in polynomial], axis=-1)

    knots, t = np.array([0.0, 0.3, 1.1, 1.5]), np.linspace(0.0, 1.5, 101)
    trajectory = Trajectory(knots, *(columns(knots, k) for k in range(3)))
    for k, sampled in enumerate(trajectory.sample(t)):
        np.testing.assert_allclose(sampled, columns(t, k), atol=1e-10)


def test_position_velocity_acceleration_are_continuous_and_derivatives_of_each_other():
    trajectory = wavy()
    eps = 1e-7
    for knot in trajectory.time[1:-1]:
        for before, after in zip(trajectory.sample(knot - eps), trajectory.sample(knot + eps)):
            np.testing.assert_allclose(before, after, atol=2e-4)
    t = np.linspace(0.01, trajectory.end - 0.01, 500)
    q0, v0, _ = trajectory.sample(t - 1e-5)
    q1, v1, _ = trajectory.sample(t + 1e-5)
    _, v, a = trajectory.sample(t)
    np.testing.assert_allclose((q1 - q0) / 2e-5, v, atol=1e-6)
    np.testing.assert_allclose((v1 - v0) / 2e-5, a, atol=1e-3)


def test_scalar_and_array_agree_and_ends_are_held():
    trajectory = wavy()
    q, v, a = trajectory.sample([-1.0, 0.7, 99.0])
    np.testing.assert_allclose(trajectory.sample(0.7)[0], q[1], atol=1e-14)
    np.testing.assert_allclose(q[0], trajectory.position[0])
    np.testing.assert_allclose(q[2], trajectory.position[-1])
    assert not v[[0, 2]].any() and not a[[0, 2]].any() and v[1].any()


def test_shifted_and_concatenated():
    first, pause = wavy(), hold(wavy().position[-1], 0.5, start=7.0)
    joined = concatenate([first, pause])
    assert joined.duration == pytest.approx(first.duration + 0.5)
    np.testing.assert_allclose(joined.sample(0.6)[0], first.sample(0.6)[0])
    np.testing.assert_allclose(first.shifted(3.0).sample(3.6)[0], first.sample(0.6)[0])
    with pytest.raises(ValueError, match='begins at'):
        concatenate([first, hold(np.zeros(3) + 9.0, 1.0)])


@pytest.mark.parametrize('change', [
    {'time': [0.0, 0.0]}, {'time': [1.0]}, {'position': [[0.0, 1.0], [np.nan, 1.0]]},
    {'velocity': [[0.0], [0.0]]}, {'acceleration': [[0.0, 0.0]] * 3}])
def test_arrays_that_do_not_fit_are_refused(change):
    fields = {'time': [0.0, 1.0], **{k: np.zeros((2, 2)) for k in
                                     ('position', 'velocity', 'acceleration')}}
    Trajectory(**fields)
    with pytest.raises(ValueError):
        Trajectory(**{**fields, **change})


def test_arrays_are_read_only():
    with pytest.raises(ValueError):
        wavy().position[0, 0] = 1.0


def test_csv_round_trip_and_wanted_order(tmp_path):
    trajectory, path = wavy(), tmp_path / 'm.csv'
    write_trajectory_csv(path, ('a', 'ns/b', 'c.d'), trajectory)
    joints, read = read_trajectory_csv(path)
    assert joints == ('a', 'ns/b', 'c.d')
    np.testing.assert_allclose(read.acceleration, trajectory.acceleration, atol=1e-7)
    _, turned = read_trajectory_csv(path, ('c.d', 'a'))
    np.testing.assert_allclose(turned.velocity, trajectory.velocity[:, [2, 0]], atol=1e-8)


@pytest.mark.parametrize('text, said', [
    (f'"{200000 * "1"}"', 'cannot be read'), ('', 'lacks columns'),
    ('t,a.position\n0,0\n1,0\n', 'a.velocity'),
    ('t,a.position,a.velocity,a.acceleration\n0,0,0,0\n', 'at least two'),
    ('t,a.position,a.velocity,a.acceleration\n0,0,0,0\n1,x,0,0\n', 'not a motion'),
    ('t,a.position,a.velocity,a.acceleration\n0,0,0,0\n1,0\n', 'not a motion')])
def test_a_wrong_csv_is_refused_with_a_sentence(tmp_path, text, said):
    path = tmp_path / 'm.csv'
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=said):
        read_trajectory_csv(path)


def test_a_missing_csv_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match='cannot be read'):
        read_trajectory_csv(tmp_path / 'none.csv')
