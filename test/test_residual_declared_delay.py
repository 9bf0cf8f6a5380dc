"""A delay that the model declares is kept, and grows, in seconds, whatever share and shift say."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from residual_helpers import declared_model, diagnosed, noise_of, recorded, told

from hand_load_estimator.effects import LATE
from hand_load_estimator.residual.add import better_model, identified_again
from hand_load_estimator.residual.measured.find import declared_delays, find_residual
from hand_load_estimator.residual.tracing.hypothesis import Hypothesis
from hand_load_estimator.torque.columns import EffectUse
from hand_load_estimator.torque_model import TorqueModel

JOINT = 2


def delaying(share, shift, std=0.02):
    """Return declared_model with a delay of one joint, of which a share comes late."""
    model = declared_model()
    count = len(model.mean)
    covariance = np.zeros((count + 1, count + 1))
    covariance[:count, :count], covariance[count, count] = model.covariance, std ** 2
    uses = (*model.uses, EffectUse('time_delay', JOINT, {'shift': shift}))
    return TorqueModel(model.robot, uses, False, np.append(model.mean, share), covariance,
                       model.residuals, model.recordings, model.temperatures)


def late_by(delay, joint=JOINT):
    """Return an effect: one joint reports its torque late."""
    def effect(run):
        now, time = run.torque[:, joint], run.motion.stamp
        out = np.zeros_like(run.torque)
        out[:, joint] = np.interp(time - delay, time, now) - now
        return out
    return effect


@pytest.mark.parametrize('share', [1.0, 0.98, 0.8, 0.7])
def test_a_joint_that_tells_nothing_keeps_its_delay(share):
    evidence = recorded()[0]
    silent = np.zeros(evidence.torque.shape, bool)
    silent[:, JOINT] = True
    model = delaying(share, 0.02)
    again = identified_again(model, model.uses, (replace(evidence, clipped=silent),))
    assert declared_delays(again) == {JOINT: pytest.approx(share * 0.02, rel=1e-6)}


@pytest.mark.parametrize('std', [0.005, 0.1])
def test_a_right_delay_is_confirmed_by_data_and_not_taken_twice(std):
    model = delaying(0.8, 0.02, std)
    again = identified_again(model, model.uses, recorded(late_by(0.016))[:1])
    assert declared_delays(again) == {JOINT: pytest.approx(0.016, rel=0.03)}


def test_a_delay_that_grew_by_less_than_itself_is_told_as_a_whole():
    before, now = 0.02, 0.038
    diagnosis, better = diagnosed(late_by(now), model=delaying(1.0, before))
    assert told(diagnosis) == {'time_delay': better.robot.joints[JOINT:JOINT + 1]}
    assert declared_delays(better) == {JOINT: pytest.approx(now, rel=0.05)}
    assert diagnosis.after[JOINT] < 1.05 * noise_of(better.robot)[JOINT]


def test_a_delay_that_grew_is_told_as_a_whole():
    diagnosis, better = diagnosed(late_by(0.045), model=delaying(1.0, 0.02))
    assert told(diagnosis) == {'time_delay': better.robot.joints[JOINT:JOINT + 1]}
    (finding,) = diagnosis.findings
    assert finding.parameters['delay'][0] == pytest.approx(0.045, rel=0.05)
    assert finding.parameters['share'][0] == pytest.approx(1.0, abs=0.02)
    assert diagnosis.after[JOINT] < 1.05 * noise_of(better.robot)[JOINT]


@pytest.mark.parametrize('share, late', [(0.8, {JOINT: 0.016}), (0.0, {}), (-0.2, {})])
def test_a_share_of_nothing_is_no_delay(share, late):
    assert declared_delays(delaying(share, 0.02)) == pytest.approx(late)


def test_what_a_joint_does_is_searched_as_late_as_its_model_says():
    residual = find_residual(delaying(0.8, 0.05), recorded()[:1])
    assert residual.delays == residual.declared == {JOINT: pytest.approx(0.04)}
    step = np.repeat([0.0, 1.0], [200, len(residual.dt) - 200])[:, None]
    (late,) = residual.reported({JOINT: step}).values()
    # At 50 Hz two samples later; other joints at once.
    np.testing.assert_allclose(late[:, 0], np.roll(step[:, 0], 2) * (np.arange(len(late)) > 1))
    assert residual.reported({0: step})[0] is step


def test_delays_of_other_joints_may_come_beside_one_that_grew():
    def effect(run):
        return late_by(0.045)(run) + late_by(0.03, 1)(run)
    diagnosis, better = diagnosed(effect, model=delaying(1.0, 0.02))
    assert told(diagnosis) == {'time_delay': better.robot.joints[1:3]}
    assert declared_delays(better) == {1: pytest.approx(0.03, rel=0.1),
                                       JOINT: pytest.approx(0.045, rel=0.1)}


def test_delays_that_are_declared_alike_are_each_their_own():
    """Two with the same figures, of a file that somebody wrote."""
    def effect(run):
        return late_by(0.02)(run) + late_by(0.035, 1)(run)
    model, evidence = also_delaying(delaying(1.0, 0.025, 0.5)), recorded(effect)
    own = identified_again(model, model.uses, evidence)
    assert declared_delays(own) == {1: pytest.approx(0.035, abs=0.005),
                                    JOINT: pytest.approx(0.02, abs=0.005)}
    both = identified_again(model, model.uses, evidence, together={1, JOINT})
    one, other = (use.shape['shift'] for use in both.uses if use.name == LATE)
    assert 0.022 < one == other < 0.033


@pytest.mark.parametrize('common', [True, False])
def test_a_delay_that_joints_have_in_common_stays_one(common):
    def effect(run):
        return late_by(0.02)(run) + late_by(0.03, 1)(run)
    parts = tuple((Hypothesis(LATE, j, {}, np.ones(1), {'shift': 0.025}), None)
                  for j in (1, JOINT))
    chosen = SimpleNamespace(name=LATE, parts=parts, joints=[1, JOINT], common=common)
    better = better_model(declared_model(), [SimpleNamespace(chosen=chosen, alternatives=())],
                          recorded(effect))
    one, other = (use.shape['shift'] for use in better.uses if use.name == LATE)
    assert (one == other) == common


def also_delaying(model, joint=1, std=0.5):
    """Return a model with delays that declares one of another joint like its last."""
    use, where = model.slices()[-1]
    count = len(model.mean)
    covariance = np.pad(model.covariance, (0, 1))
    covariance[count, count] = std ** 2
    return replace(model, uses=(*model.uses, replace(use, joint=joint)),
                   mean=np.append(model.mean, model.mean[where]), covariance=covariance)
