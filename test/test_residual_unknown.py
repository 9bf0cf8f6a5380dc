"""What no effect explains is `unknown`: of a variable, of a rhythm in time, or of nothing."""

from types import SimpleNamespace

from core_helpers import four_axes
import numpy as np
import pytest
from ringing_helpers import JOINTS, NEEDED, recorded, STEP

from hand_load_estimator.residual.diagnosis import CONFIRMED, Evidence, Structure, SUSPECTED
from hand_load_estimator.residual.doubts import unknown
from hand_load_estimator.residual.doubts.function_left import FunctionLeft
from hand_load_estimator.residual.doubts.unknown import unknown_left
from hand_load_estimator.residual.measured.structure import CONSTANT, TEMPERATURE, TIME

NAMES = four_axes().joints[:JOINTS]
NOTHING = np.zeros(JOINTS)


def structure(share, pairs=None):
    """Return the Structure of residuals that follow variables {name: (n,)} and joints (n, n)."""
    return Structure(np.ones(JOINTS), 0.1 * np.ones(JOINTS), share,
                     dict.fromkeys(share, np.full(JOINTS, 0.01)),
                     np.zeros((JOINTS, JOINTS)) if pairs is None else pairs,
                     np.full((JOINTS, JOINTS), 0.01))


def unknowns(rest_of, after):
    """Return the Findings on rest_of(noise (N, n), time (N,)) of the Structure `after`."""
    noise, speed, dt, owner, time = recorded(6)
    rest = rest_of(noise, time)
    x = SimpleNamespace(v=speed, a=np.gradient(speed, STEP, axis=0), q=speed, gear=speed)
    residual = SimpleNamespace(
        x=x, dt=dt, owner=owner, moving=np.ones(rest.shape, dtype=bool),
        weights=np.ones(rest.shape), starts=np.arange(0, len(rest), 250),
        observations=len(rest) // 250, noise=noise.std(axis=0), residual=rest, torque=rest)
    model = SimpleNamespace(robot=SimpleNamespace(n=JOINTS, joints=NAMES))
    trace = SimpleNamespace(steps=(), drifted=(), trials=1000, needed=NEEDED / 4.0)
    return unknown_left(model, residual, rest, tuple(range(JOINTS)), trace, (after, after))


# The first joint follows its temperature, the last one the first one's motion; all have a mean,
# and drift with time, which says nothing.
OTHERS = structure({CONSTANT: NOTHING + 0.9, TIME: NOTHING + 0.8,
                    TEMPERATURE: np.array([0.7, 0.1, 0.1])},
                   0.7 * np.eye(JOINTS)[[1, 1, 0]] * np.array([[0.0], [0.0], [1.0]]))


@pytest.mark.parametrize('size, after, verdict', [
    (3.0, structure({}), CONFIRMED), (3.0, OTHERS, CONFIRMED), (0.0, structure({}), SUSPECTED)])
def test_what_is_left_is_confirmed_where_it_rings(size, after, verdict):
    found, = unknowns(lambda noise, time: noise + size * noise.std() * np.sin(
        2.0 * np.pi * 1.3 * time)[:, None], after)
    assert found.verdict == verdict and found.variables == ('time',) and found.joints == NAMES
    if verdict == CONFIRMED:
        assert found.parameters['frequency'][0] == pytest.approx(1.3, rel=0.05)
        assert (found.explained > 0.3).all() and found.evidence.gain > NEEDED
    else:
        assert not found.parameters and not found.explained.any()


def test_a_swing_that_a_joint_does_not_show_is_confirmed_where_it_rings():
    ringing, rest = unknowns(lambda noise, time: noise + np.array([3.0, 3.0, 0.0]) * noise.std()
                             * np.sin(2.0 * np.pi * 1.3 * time)[:, None], structure({}))
    assert (ringing.verdict, ringing.variables, ringing.joints) == (
        CONFIRMED, ('time',), NAMES[:2])
    assert ringing.parameters['frequency'][0] == pytest.approx(1.3, rel=0.05)
    assert (rest.verdict, rest.joints, rest.parameters) == (SUSPECTED, NAMES[2:], {})


def test_temperature_and_the_motion_of_any_joint_are_variables_too():
    found = unknowns(lambda noise, _: noise, OTHERS)
    assert {f.joints: f.variables for f in found} == {
        NAMES[:1]: ('temperature',), NAMES[1:2]: ('time',),
        NAMES[2:]: (f'the motion of {NAMES[0]}',)}
    assert all(f.verdict == SUSPECTED for f in found)


def test_a_function_that_tells_more_than_what_is_named_is_confirmed(monkeypatch):
    told = FunctionLeft('velocity', Evidence(500.0, 50.0, NEEDED, 12, 1000, np.nan, 'backlash',
                                             400.0), 0.9)
    monkeypatch.setattr(unknown, 'function_left', lambda robot, trace, j: told if j == 1 else None)
    found = unknowns(lambda noise, _: noise, structure({}))
    confirmed, rest = found
    assert (confirmed.verdict, confirmed.variables, confirmed.joints) == (
        CONFIRMED, ('velocity',), NAMES[1:2])
    assert confirmed.evidence.gain == 500.0 and confirmed.evidence.rms > 0.0
    np.testing.assert_array_equal(confirmed.explained, [0.0, 0.9, 0.0])
    assert rest.joints == (NAMES[0], NAMES[2]) and rest.verdict == SUSPECTED
