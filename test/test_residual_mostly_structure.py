"""Where most of what is left is structure without a name, it is an `unknown` effect."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from residual_helpers import declared_model, diagnosed, told
import pytest

from hand_load_estimator.residual.diagnosis import (CONFIRMED, Evidence, Finding, Structure,
                                                    SUSPECTED, UNKNOWN)
from hand_load_estimator.residual.doubts.mostly_structure import drifting, mostly_structure
from hand_load_estimator.residual.measured.structure import CONSTANT

JOINTS = declared_model().robot.joints
ROWS, DT = 3000, 0.02


def left(structure):
    """Return (Residual as far as it is read, rest (N, 4)): noise of 1 Nm and so much structure."""
    rng, time = np.random.default_rng(3), DT * np.arange(ROWS)
    swing = np.sin(2.0 * time)[:, None] * np.ones(4)
    return SimpleNamespace(
        x=SimpleNamespace(q=swing),
        moving=np.ones((ROWS, 4), bool), weights=np.ones((ROWS, 4)), dt=np.full(ROWS, DT),
        messages=np.ones(ROWS), owner=np.zeros(ROWS, int), observations=12), \
        rng.normal(size=(ROWS, 4)) + np.array(structure) * swing


def following(position):
    """Return a Structure of which position foretells so much at each joint (4,)."""
    return Structure(np.ones(4), 0.1 * np.ones(4), {'position': np.array(position)},
                     {'position': np.full(4, 0.01)}, np.zeros((4, 4)), np.ones((4, 4)))


def finding(name, joint, recording=''):
    return Finding(name, (JOINTS[joint],), {}, np.eye(4)[joint],
                   Evidence(100.0, 10.0, 30.0, 12, 900, 1.0), (), '', False, CONFIRMED,
                   recording=recording)


def unknowns(structure, named=()):
    residual, rest = left(structure)
    both = following([0.5] * 4), following([0.0, 0.6, 0.0, 0.6])
    return mostly_structure(declared_model().robot, residual, rest, named, both, 900)


def test_what_is_mostly_structure_is_unknown_with_what_it_follows():
    found = unknowns([4.0, 4.0, 0.5, 0.0], (finding('torque_ripple', 0),))
    assert [(f.name, f.joints, f.variables, f.verdict) for f in found] == [
        (UNKNOWN, JOINTS[:1], ('time',), SUSPECTED),
        (UNKNOWN, JOINTS[1:2], ('position',), SUSPECTED)]
    assert found[0].evidence.rms == pytest.approx(3.0, rel=0.05)
    assert 'depends on position' in found[1].advice
    assert [[(p.joint, p.variable, p.fitted) for p in f.pictures] for f in found] == [
        [(JOINTS[0], 'time [s]', False)],
        [(JOINTS[1], 'position [rad]', False), (JOINTS[1], 'time [s]', False)]]
    against = found[1].pictures[0]
    # 4 Nm per unit of the swing it follows, within the errors of its bins.
    assert np.mean(np.abs(against.mean - 4.0 * against.x) < 2.0 * against.std) > 0.9


def test_a_mean_is_nothing_that_it_follows():
    residual, rest = left([4.0, 0.0, 0.0, 0.0])
    mean = Structure(np.ones(4), 0.1 * np.ones(4), {CONSTANT: np.full(4, 0.6)},
                     {CONSTANT: np.full(4, 0.01)}, np.zeros((4, 4)), np.ones((4, 4)))
    (found,) = mostly_structure(declared_model().robot, residual, rest, (), (mean, mean), 900)
    assert found.variables == ('time',) and 'follows nothing of the motion' in found.advice


@pytest.mark.parametrize('named', [finding(UNKNOWN, 0), finding('load_change', 0, 'run 1')])
def test_what_has_been_told_is_not_told_twice(named):
    assert unknowns([4.0, 0.0, 0.0, 0.0], (named,)) == ()


def test_the_average_of_what_drifts_is_only_suspected():
    def unknown(joint, *variables):
        return replace(finding(UNKNOWN, joint), verdict=SUSPECTED, variables=variables)
    named = (finding('torque_offset', 0), finding('torque_ripple', 0), finding('torque_offset', 1),
             finding('torque_offset', 2), unknown(0, 'time'), unknown(1, 'position', 'time'))
    time = replace(following([0.0] * 4), share={'time': np.array([0.9, 0.2, 0.9, 0.9])},
                   chance={'time': np.full(4, 0.01)})
    found, said = drifting(named, JOINTS, (time, time))
    assert [f.verdict for f in found] == [SUSPECTED, *[CONFIRMED] * 3, SUSPECTED, SUSPECTED]
    (sentence,) = said
    assert sentence.startswith(f'{JOINTS[0]}: torque_offset is only suspected')
    # What rings has no name either, and no average.
    assert drifting(named, JOINTS, (following([0.0] * 4),) * 2) == (named, ())


def test_an_effort_that_drifts_has_no_new_offset():
    """Of a sensor, say: 1.6 times the noise per second."""
    def drifts(run):
        time = run.motion.stamp - run.motion.stamp[0]
        return (1.6 * run.noise * time[:, None]) * (np.arange(run.robot.n) == 1)
    diagnosis, _ = diagnosed(drifts)
    assert not told(diagnosis)
    assert any(f.name == UNKNOWN and f.joints == (JOINTS[1],) and f.variables == ('time',)
               for f in diagnosis.findings)
