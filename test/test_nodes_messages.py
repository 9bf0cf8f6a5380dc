"""Estimates as messages: orders, frames, pictures; time stamps and pace."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from hand_load_estimator.load import LoadEstimate, LoadParameters
from hand_load_estimator.nodes.diagnostics import OK, STALE
from hand_load_estimator.nodes.estimate_messages import (covariance_message, estimate_status,
                                                         inertia_message, residual_message,
                                                         vector_of_inertia)
from hand_load_estimator.nodes.markers import equivalent_ellipsoid, estimate_markers
from hand_load_estimator.nodes.pace import Pace
from hand_load_estimator.nodes.stamps import StampBase, time_message
from hand_load_estimator.nodes.throttle import Throttle


def some_estimate(status='ESTIMATING', mass=2.0):
    rng = np.random.default_rng(3)
    root = rng.normal(size=(10, 10)) * 0.1
    box = mass / 12.0 * np.diag([0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2])
    mean = LoadParameters(mass, [0.01, -0.02, 0.1], box).to_message()
    return LoadEstimate(12.5, mean, root @ root.T, [True] * 4 + [False] * 6, status, 'because', 7)


def test_inertia_message_keeps_the_order():
    message = inertia_message(np.arange(1.0, 11.0), Time(sec=5), 'tool0')
    i = message.inertia
    assert (i.m, i.com.x, i.com.y, i.com.z) == (1.0, 2.0, 3.0, 4.0)
    assert (i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz) == (5.0, 6.0, 7.0, 8.0, 9.0, 10.0)
    assert message.header.frame_id == 'tool0' and message.header.stamp.sec == 5
    assert vector_of_inertia(i) == list(range(1, 11))


def test_covariance_message_is_row_major_with_named_rows():
    covariance = np.arange(100.0).reshape(10, 10)
    message = covariance_message(covariance)
    assert np.array_equal(np.reshape(message.data, (10, 10)), covariance)
    rows, columns = message.layout.dim
    assert (rows.size, rows.stride, columns.size, columns.stride) == (10, 100, 10, 10)
    assert rows.label == 'rows:m,x,y,z,ixx,ixy,ixz,iyy,iyz,izz'


def test_residual_message_names_its_joints():
    message = residual_message(['a', 'b'], np.array([0.5, math.nan]), Time())
    assert message.name == ['a', 'b'] and message.effort[0] == 0.5
    assert math.isnan(message.effort[1]) and not message.position


def test_status_tells_what_the_contract_promises():
    status = estimate_status('estimator: load', some_estimate(), 0.25, 'lstm', 0.0)
    values = {pair.key: pair.value for pair in status.values}
    assert status.message == 'ESTIMATING' and status.level == OK
    assert values == {'determined': '1 1 1 1 0 0 0 0 0 0', 'age': '0.25', 'reason': 'because',
                      'load_id': '7', 'method': 'lstm', 'tared mass [kg]': '0'}
    assert estimate_status('', some_estimate('STALE_INPUT'), 1.0, 'lstm', 0.0).level == STALE


def test_equivalent_ellipsoid_has_the_inertia():
    diameters = np.array([0.1, 0.2, 0.4])
    squares = (diameters / 2.0) ** 2
    inertia = 3.0 / 5.0 * np.diag(np.sum(squares) - squares)
    found, _ = equivalent_ellipsoid(3.0, inertia)
    assert np.allclose(np.sort(found), diameters)


@pytest.mark.parametrize('mass', [2.0, 0.0, -0.1])
def test_markers_can_be_drawn_whatever_the_mass(mass):
    estimate = LoadEstimate(0.0, [mass, 0, 0, 0.1] + [0.0] * 6, np.eye(10) * 0.01,
                            [False] * 10, 'ESTIMATING')
    markers = estimate_markers(estimate, Header(frame_id='tool0')).markers
    assert [m.id for m in markers] == [0, 1, 2, 3]
    for marker in markers:
        assert min(marker.scale.x, marker.scale.y, marker.scale.z) > 0.0
        assert marker.header.frame_id == 'tool0' and marker.lifetime.sec == 1
    assert markers[1].scale.x == pytest.approx(0.4)  # two sigma of 0.1 m to each side


def test_marker_axes_are_those_of_the_covariance():
    angle = 0.4
    axes = np.array([[math.cos(angle), -math.sin(angle), 0.0],
                     [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    covariance = np.eye(10)
    covariance[1:4, 1:4] = axes @ np.diag([0.04, 0.01, 0.0025]) @ axes.T
    estimate = LoadEstimate(0.0, np.zeros(10), covariance, [False] * 10, 'ESTIMATING')
    marker = estimate_markers(estimate, Header()).markers[1]
    q = marker.pose.orientation
    w, v = q.w, np.array([q.x, q.y, q.z])
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    rotation = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    scale = np.array([marker.scale.x, marker.scale.y, marker.scale.z]) / 4.0
    assert np.allclose(rotation @ np.diag(scale**2) @ rotation.T, covariance[1:4, 1:4])


def test_stamps_survive_the_way_there_and_back_to_the_nanosecond():
    base = StampBase()
    for sec, nanosec in ((1795255833, 2000000), (1795255833, 2000001), (1795259999, 999999999),
                         (1795255000, 5)):
        stamp = Time(sec=sec, nanosec=nanosec)
        assert abs(base.seconds(stamp)) < 1e5
        assert base.message(base.seconds(stamp)) == stamp


def test_time_message_splits_nanoseconds():
    assert time_message(3 * 10**9 + 7) == Time(sec=3, nanosec=7)
    assert time_message(-5) == Time()


def test_pace_follows_the_factor():
    pace = Pace(2.0)
    assert pace.target(100.0, 0.0) == 0.0
    assert pace.target(100.05, 0.08) == pytest.approx(0.1)
    pace.set_factor(0.5, 100.05, 0.1)
    assert pace.target(100.15, 0.14) == pytest.approx(0.15)


def test_pace_gives_up_time_it_cannot_catch_up_with():
    """A machine that computes 0.5 s per second must not owe ever more simulated time."""
    pace, real, simulated = Pace(1.0), 0.0, 0.0
    pace.count(real, simulated)
    for _ in range(1000):
        target = pace.target(real, simulated)
        assert target - simulated <= 0.1 + 1e-9
        simulated = min(target, simulated + 0.005)
        real += 0.01
    pace.count(real, simulated)
    assert pace.achieved == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize('rate, passed', [(50.0, 500), (25.0, 250), (1000.0, 500), (30.0, 300)])
def test_throttle_keeps_the_rate_in_spite_of_jitter(rate, passed):
    rng = np.random.default_rng(0)
    throttle = Throttle(rate)
    times = 7.0 + 0.02 * np.arange(500) + rng.uniform(-0.003, 0.003, 500)
    assert abs(sum(throttle.due(t) for t in times) - passed) <= 2
    assert throttle.due(1.0), 'a clock that goes back does not stop it'
    assert not throttle.due(1.0 + 0.5 / rate)
