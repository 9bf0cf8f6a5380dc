"""The residual watch: silent while the model is right, names the joint when it is not."""

from dataclasses import replace

from core_helpers import block, exact_model, feed, messages, pipeline_of, warm
import numpy as np
from plant_helpers import effects
import pytest

from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.estimators.model_trust import MISFIT
from hand_load_estimator.estimators.residual_watch import (CALM, EARLIER, ENOUGH, LIMIT,
                                                           ResidualWatch)
from hand_load_estimator.plant import JointEvent, simulate_motion
from hand_load_estimator.seeds import SHIPPED_MODEL_PLANT
from hand_load_estimator.simulation.simulate_motions import named_motion

JOINT = 2
SECONDS = 32.0


@pytest.fixture(scope='module')
def model():
    return exact_model('four')


@pytest.fixture(scope='module')
def stream(model):
    return messages(model, block(2.0), SECONDS)


def rubbed(model, stream, since=0.0, until=np.inf, times=2.0, joint=JOINT):
    """Return Messages with more Coulomb friction at a joint: so many times the torque noise."""
    out = []
    for m in stream:
        effort = np.array(m.effort)
        if since <= m.stamp - stream[0].stamp < until:
            effort[joint] += times * model.residuals.rmse[joint] * np.sign(m.velocity[joint])
        out.append(replace(m, effort=effort))
    return out


def follow(pipeline, stream):
    """Feed a stream with temperatures every 10 s; yield the pipeline after each message."""
    for k, m in enumerate(stream):
        if k % 1000 == 0:
            warm(pipeline)
        feed(pipeline, [m])
        yield pipeline


def watched(model, stream):
    """Return the watch of a pipeline that was fed a stream."""
    *_, pipeline = follow(pipeline_of(model), stream)
    return pipeline.watch


@pytest.mark.parametrize('mass', [0.0, 4.0])
def test_a_model_that_is_right_has_not_aged(model, mass):
    watch = watched(model, messages(model, block(mass), SECONDS, seed=int(mass)))
    assert not watch.aged and watch.enough.all()
    assert (watch.ratio > 0.3).all() and (watch.ratio < CALM).all()


@pytest.mark.parametrize('joint', range(4))
def test_the_joint_that_has_aged_is_named(model, stream, joint):
    watch = watched(model, rubbed(model, stream, joint=joint))
    assert watch.aged[0].joint == model.robot.joints[joint]
    assert watch.aged[0].ratio == pytest.approx(watch.ratio[joint]) and watch.ratio[joint] > LIMIT


class Doubting:
    """A Method that knows no load and is wrong of it, of torques `factor` times as wide."""

    def __init__(self, method, factor):
        self._method, self.factor = method, factor

    def __getattr__(self, name):
        return getattr(self._method, name)

    def belief(self):
        belief = self._method.belief()
        return replace(belief, mean=belief.mean + 0.5, covariance=1e6 * belief.covariance)


@pytest.mark.parametrize('factor, told', [(0.9 * MISFIT, False), (1.1 * MISFIT, True)])
def test_where_the_model_explains_nothing_no_load_need_be_known(model, stream, factor, told):
    """It is then held to what it states; while it explains the torques the load is waited for."""
    watch = ResidualWatch(model.robot.joints, model.residuals.intensity)
    pipeline = pipeline_of(model)
    pipeline.watch.update = lambda sample, prediction, method: watch.update(
        sample, prediction, Doubting(method, factor))
    for _ in follow(pipeline, rubbed(model, stream)):
        pass
    assert [aged.joint for aged in watch.aged] == ([model.robot.joints[JOINT]] if told else [])
    assert watch.seconds.any() == told


def test_since_when_and_after_how_much_motion(model):
    stream = messages(model, block(2.0), 70.0)
    watch = watched(model, rubbed(model, stream, since=30.0))
    worst = watch.aged[0]
    assert 29.0 < worst.since - stream[0].stamp < 40.0
    assert 20.0 < worst.motion < 40.0
    assert worst.motion < watch.seconds[JOINT]


def test_what_is_over_is_forgotten_with_hysteresis(model):
    stream = rubbed(model, messages(model, block(2.0), 180.0), until=25.0)
    ratios = []
    for pipeline in follow(pipeline_of(model), stream):
        if pipeline.watch.aged:
            ratios.append(pipeline.watch.aged[0].ratio)
    assert ratios[0] > LIMIT and CALM < ratios[-1] < LIMIT
    assert not pipeline.watch.aged


def test_too_little_motion_says_nothing(model, stream):
    watch = watched(model, rubbed(model, stream)[:1500])
    assert not watch.aged and (watch.seconds < ENOUGH).all() and watch.seconds.any()
    still = watched(model, rubbed(model, messages(model, block(2.0), 20.0, rest=99.0)))
    assert not still.seconds.any()


def test_load_changes_and_a_push_are_no_ageing(model):
    """Every 6 s another load; a push of 2 s."""
    parts = [messages(model, block(mass), 6.0, seed=k, rest=0.2)
             for k, mass in enumerate((0.0, 3.0, 0.5, 4.0, 0.0, 2.0, 0.2, 3.0, 1.0))]
    stream = [replace(m, stamp=m.stamp + 6.5 * k) for k, part in enumerate(parts) for m in part]
    for pipeline in follow(pipeline_of(model), stream):
        assert not pipeline.watch.aged
    assert pipeline.load_id >= 6 and pipeline.watch.enough.any()
    pushed = rubbed(model, messages(model, block(2.0), SECONDS), 25.0, 27.0, 20.0)
    assert not watched(model, pushed).aged


def test_a_load_swapped_at_a_reset_is_no_ageing(model):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(0.2), 30.0))
    pipeline.reset()
    feed(pipeline, [replace(m, stamp=m.stamp + 30.5) for m in messages(model, block(4.0), 30.0)])
    assert not pipeline.watch.aged and pipeline.watch.enough.all()


def test_after_tare_the_tool_is_no_ageing(model):
    pipeline = warm(pipeline_of(model))
    feed(pipeline, messages(model, block(3.0), 15.0))
    pipeline.tare(pipeline.last_stamp)
    feed(pipeline, [replace(m, stamp=m.stamp + 15.5) for m in messages(model, block(3.0), 30.0)])
    assert not pipeline.watch.aged and (pipeline.watch.ratio < CALM).all()


def test_a_hidden_effect_of_a_simulated_arm_is_named():
    """The arm of the shipped model, with Coulomb friction of twice the torque noise more."""
    pipeline = build_pipeline('ur10e', 'bayes')
    robot = pipeline.model.robot
    motion = named_motion('excite', robot, 50.0, seed=3)
    hidden = effects(robot, {'name': 'coulomb_friction', 'joints': ['elbow_joint'], 'strength': 2})
    for event in simulate_motion(robot, motion.time, motion.position, motion.velocity,
                                 motion.acceleration, seed=SHIPPED_MODEL_PLANT, rate=125.0,
                                 effects=hidden, start_temperature=25.0):
        if isinstance(event, JointEvent):
            pipeline.joint_state(event.stamp, robot.joints, event.position, event.velocity,
                                 event.effort)
            continue
        for joint, celsius in zip(robot.joints, event.celsius):
            pipeline.temperature_reading(joint, celsius)
    assert pipeline.watch.aged[0].joint == 'elbow_joint'


def test_a_restart_forgets_no_joint_and_says_that_it_was_before(model, stream):
    """All that was seen goes on; what the hand holds is found anew."""
    *_, old = follow(pipeline_of(model), rubbed(model, stream, since=5.0))
    (told,) = old.watch.aged
    new = pipeline_of(model)
    new.restore({name: np.array(value, dtype=float) for name, value in old.state().items()},
                'as it was')
    # Stamps of another process count from another second.
    assert new.watch.aged == (replace(told, since=EARLIER),)
    later = [replace(m, stamp=m.stamp + 60.0) for m in rubbed(model, stream)]
    *_, new = follow(new, later)
    (again,) = new.watch.aged
    assert again.joint == told.joint and again.since == EARLIER
    assert again.motion > told.motion + 10.0
    assert not pipeline_of(model).watch.aged


def test_a_state_without_the_watch_is_refused(model, stream):
    state = {name: np.array(value, dtype=float) for name, value in
             pipeline_of(model).state().items() if not name.startswith('watch_')}
    with pytest.raises(ValueError, match='watch_square is missing'):
        pipeline_of(model).restore(state, 'as it was')
