"""A plain function is `unknown` where it tells surely more than what is named at a joint."""

from types import SimpleNamespace

from core_helpers import four_axes
import numpy as np
import pytest

from hand_load_estimator.effects import LATE
from hand_load_estimator.residual.doubts.function_left import function_left
from hand_load_estimator.residual.measured.blocks import Blocks
from hand_load_estimator.residual.tracing.candidate import single, Step
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.residual.tracing.plain_functions import functions_judged, hats

ROBOT, JOINT, NEEDED, NOISE = four_axes(), 1, 30.0, 0.1
LENGTH, BLOCK, SLOW, FAST = 1500, 150, 1.6, 3.1


def speeds(tops):
    """Return speeds (N, n) of recordings with such top speeds, and their number (N,)."""
    rng = np.random.default_rng(3)
    # Joints are slow most of the time.
    runs = [top * rng.uniform(-1.0, 1.0, (LENGTH, ROBOT.n)) ** 15 for top in tops]
    return np.concatenate(runs), np.repeat(np.arange(len(tops)), LENGTH)


def peak(speed):
    """Return friction (N,) [Nm] that peaks at a speed which joints only pass through."""
    return 3.0 * np.sign(speed) / (1.0 + ((np.abs(speed) - 1.1) / 0.2) ** 2)


def viscous(speed):
    return speed


def coulomb(speed):
    return np.sign(speed)


class Traced:
    """As much of a Trace as is asked: columns {name: function} named at JOINT."""

    def __init__(self, torque, columns, tops=(SLOW, SLOW, SLOW, FAST), folds=None):
        v, recording = speeds(tops)
        noise = np.random.default_rng(4).normal(size=v.shape) * NOISE
        noise[:, JOINT] += torque(v[:, JOINT])
        still = np.zeros_like(v)
        self.residual = SimpleNamespace(x=SimpleNamespace(v=v, q=still, a=still, gear=still,
                                                           drive=still))
        starts = np.arange(0, len(v), BLOCK)
        self._blocks = Blocks(
            noise, np.full(v.shape, NOISE ** -2), [np.zeros((len(v), 1))] * ROBOT.n, starts,
            recording[starts] if folds is None else np.arange(len(starts)) % folds)
        self.needed, self.trials, self.drifted, self.steps = NEEDED, 1000, [], []
        self.steps = [self._step(name, {JOINT: of(v[:, JOINT])[:, None]})
                      for name, of in columns.items()]
        self.worth = True

    def _step(self, name, columns):
        own = Hypothesis(name, JOINT, columns, np.ones(1), {})
        return Step(single(own, self._blocks.evaluate(columns)), (), None, NEEDED)

    def everywhere(self, name):
        """Name an effect that moves all joints."""
        v = self.residual.x.v
        self.steps.append(self._step(name, {j: v[:, j, None] for j in range(ROBOT.n)}))

    def beside(self, *steps):
        blocks = self._blocks
        for step in self.steps:
            if not any(step is other for other in steps):
                blocks = blocks.beside(step.chosen.columns)
        return blocks

    def matters(self, candidate):
        return self.worth

    def function(self):
        return function_left(ROBOT, self, JOINT)


def drag(speed):
    """Return the peak, and where the hurried recording alone has been viscous friction."""
    return np.where(np.abs(speed) > SLOW, 1.2 * viscous(speed), peak(speed))


@pytest.mark.parametrize('torque', [peak, drag])
def test_what_only_imitates_a_function_is_told_from_it(torque):
    """Of where one recording alone has been, a function fitted to the others says nothing."""
    found = Traced(torque, {'viscous_friction': viscous}).function()
    assert found.variable == 'velocity' and found.explained > 0.9
    told = found.evidence
    assert told.gain > told.needed == 4.0 * NEEDED and told.gain > 3.0 * told.gain_std
    assert told.next_best == 'viscous_friction' and 0.0 < told.margin < told.gain


@pytest.mark.parametrize('tops, folds', [((SLOW,), 4), ((SLOW, FAST), None)])
def test_one_recording_is_judged_by_its_own_parts_and_two_by_each_other(tops, folds):
    assert Traced(peak, {'viscous_friction': viscous}, tops, folds).function()


@pytest.mark.parametrize('torque', [
    viscous, lambda speed: viscous(speed) + 0.01 * peak(speed)])
def test_what_explains_nearly_all_is_told_from_no_function(torque):
    assert Traced(torque, {'viscous_friction': viscous}).function() is None


@pytest.mark.parametrize('blocks, sure', [(4, False), (10, True)])
def test_what_some_blocks_gain_and_others_lose_is_not_sure(blocks, sure):
    def at_first(speed):
        return peak(speed) * (np.arange(len(speed)) % LENGTH < blocks * BLOCK)
    assert bool(Traced(at_first, {'viscous_friction': viscous}).function()) is sure


def test_two_effects_are_weighed_together():
    def both(speed):
        return viscous(speed) + coulomb(speed)
    assert Traced(both, {'viscous_friction': viscous, 'coulomb_friction': coulomb}) \
        .function() is None
    assert Traced(both, {'viscous_friction': viscous}).function()


def test_nothing_is_asked_where_nothing_is_named_or_all_comes_late():
    assert Traced(peak, {}).function() is None
    late = Traced(peak, {'viscous_friction': viscous})
    late.everywhere(LATE)
    assert late.function() is None
    worthless = Traced(peak, {'viscous_friction': viscous})
    worthless.worth = False
    assert worthless.function() is None


def test_recordings_that_were_nowhere_alike_judge_no_function():
    found = Traced(peak, {'viscous_friction': viscous}, (SLOW, SLOW))
    found.residual.x.v[LENGTH:] += 10.0
    assert found.function() is None


def test_functions_have_corners_in_what_is_rare_and_rows_where_two_have_been():
    found = Traced(peak, {})
    v = found.residual.x.v[:, JOINT]
    # One recording leaps over what the others pass through.
    v[(np.abs(v) > 0.8) & (np.abs(v) < 1.4) & (np.arange(len(v)) >= LENGTH)] = 0.0
    (function, rows), = functions_judged(found.residual, found.beside(), np.ones(ROBOT.n), JOINT)
    assert np.abs(v[rows]).max() == pytest.approx(SLOW, rel=0.02) and np.abs(v).max() > 3.0
    assert not (rows & (np.abs(v) > 1.0) & (np.abs(v) < 1.2)).any()
    fitted, v = {}, Traced(peak, {}).residual.x.v[:, JOINT]
    inside = np.abs(v) < SLOW
    even = functions_judged(Traced(peak, {}).residual, found.beside(), np.ones(ROBOT.n), JOINT)
    for name, columns in (('even', next(even)[0].columns[JOINT]), ('quantiles', hats(v, 32))):
        theta, *_ = np.linalg.lstsq(columns[inside], peak(v[inside]), rcond=None)
        fitted[name] = np.std(peak(v[inside]) - columns[inside] @ theta)
    assert fitted['even'] < 0.1 < 0.2 < fitted['quantiles']
