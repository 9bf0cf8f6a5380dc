"""Noise of single samples: measured at any rate, blind to motion, and heard by the estimator."""

import numpy as np
import pytest

from hand_load_estimator.estimators.build import build_pipeline
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.motion import MotionFilter
from hand_load_estimator.plant import simulate_motion, TemperatureEvent
from hand_load_estimator.robot import load_robot
from hand_load_estimator.simulation.simulate_motions import named_motion
from hand_load_estimator.torque.noise import difference_gain, SampleNoise

STD = 1.2  # [Nm] of one reported torque
JOINTS = 40
UNIT = np.ones(JOINTS)


def measured(rate, torque=lambda t: 0.0, seconds=15.0, jitter=0.0, growth=lambda t: 1.0,
             stated=1e-6):
    """
    Return the density [Nm^2 s] SampleNoise finds in noise of STD at a rate [Hz], mean of JOINTS.

    jitter: of the stamps, as a share of their spacing; growth: factor on STD at a time [s];
    stated: density [Nm^2 s].
    """
    rng, still = np.random.default_rng(0), np.zeros(JOINTS)
    motion, noise = MotionFilter(JOINTS), SampleNoise(np.full(JOINTS, 0.3), stated * UNIT)
    for k in range(int(rate * seconds)):
        stamp = (k + jitter * rng.uniform()) / rate
        effort = torque(stamp) + growth(stamp) * STD * rng.normal(size=JOINTS)
        sample = motion.update(stamp, still, still, effort)
        if sample is not None and not sample.fresh:
            density = noise.update(sample.effort, sample.dt, sample.messages,
                                   UNIT > 0.0)
    return density.mean()


@pytest.mark.parametrize('jitter', [0.0, 0.1, 0.3])
@pytest.mark.parametrize('rate', [30, 50, 80, 94, 100, 125, 220, 500, 1000])
def test_white_noise_has_its_variance_times_its_spacing(rate, jitter):
    # From a beginning far too low.
    told = measured(rate, seconds=max(15.0, 900 / rate), jitter=jitter)
    assert told == pytest.approx(STD ** 2 / rate, rel=0.1)


def test_what_is_stated_holds_unless_more_is_measured_than_chance_makes():
    stated = STD ** 2 / 500
    assert measured(500, stated=stated) == pytest.approx(stated, rel=0.05)
    assert measured(500, stated=2.0 * stated) == 2.0 * stated
    assert measured(250, stated=stated) == pytest.approx(2.0 * stated, rel=0.1)


def test_more_noise_is_found_within_half_a_minute():
    """It takes as long because a knock is none: squares count up to four times the mean."""
    told = measured(100, seconds=35.0, growth=lambda t: 1.0 if t < 5.0 else 3.0)
    assert told == pytest.approx(9.0 * STD ** 2 / 100, rel=0.15)


@pytest.mark.parametrize('rate', [30, 500])
def test_motion_is_no_noise(rate):
    def carried(t):
        return 60.0 * np.sin(2.0 * np.pi * 0.7 * t)
    assert measured(rate, carried) == pytest.approx(measured(rate), rel=0.2)


def test_accelerations_of_noisy_encoders_are_hardly_noise():
    """In heavy links they were two to four times the noise of torques, though never slowly so."""
    rng, motion = np.random.default_rng(3), MotionFilter(1)
    noise, inertia, density = SampleNoise(np.array([0.3]), np.zeros(1)), 7.0, []
    for k in range(7500):
        q, v, effort = np.array([5e-6, 2e-3, STD])[:, None] * rng.normal(size=(3, 1))
        sample = motion.update(k / 500, q, v, effort)
        if sample is not None and not sample.fresh:
            difference = sample.effort - inertia * sample.a
            density.append(noise.update(difference, sample.dt, sample.messages,
                                        np.array([True]))[0])
    assert np.mean(density[-100:]) < 1.4 * STD ** 2 / 500


def test_reversals_are_hardly_noise():
    def friction(t):
        return 9.0 * np.sign(np.sin(2.0 * np.pi * 0.3 * t))
    assert measured(500, friction) < 2.0 * measured(500)


def test_a_joint_that_does_not_slide_is_not_asked():
    """Held, or turning around, friction works like noise that sliding joints do not have."""
    rng, noise = np.random.default_rng(1), SampleNoise(np.array([0.3, 0.3]), np.zeros(2))
    for k in range(1000):
        # The second joint slides now and then, never long enough for a difference.
        slides = np.array([k % 50 > 25, k % 5 > 0])
        held = np.array([0.0 if slides[0] else 5.0, 5.0])
        density = noise.update((0.3 + held) * rng.normal(size=2), 0.02, 10, slides)
    # Behind a filter that was not there, white noise looks larger than it is.
    gain = difference_gain(13, 24)
    assert density[0] == pytest.approx(70.0 * 0.3 ** 2 / gain, rel=0.4)
    assert density[1] == pytest.approx(0.3 ** 2 * 0.02)


def test_until_it_is_measured_the_residual_is_taken_for_noise():
    noise = SampleNoise(np.array([0.3, 2.0]), np.zeros(2))
    for spacing in (0.02, 0.1):
        density = noise.update(np.zeros(2), spacing, 10, np.ones(2, bool))
        np.testing.assert_allclose(density, np.array([0.09, 4.0]) * spacing)


def test_messages_that_nearly_coincide_do_no_harm():
    """At 30 Hz every message is a sample; a driver may stamp two of them 0.3 ms apart."""
    robot, pipeline = load_robot(find_shared('ur10e', 'robots')), build_pipeline('ur10e', 'bayes')
    stamps = np.arange(60) / 30.0
    stamps[30] = stamps[29] + 3e-4
    for stamp in stamps:
        pipeline.joint_state(stamp, robot.joints, np.zeros(6), np.zeros(6), np.zeros(6))
    assert pipeline.samples == 60 and np.isfinite(pipeline.residual).all()


def test_slow_joint_states_are_believed_less():
    """At 30 Hz this run had false load changes while density was thought the same as at 500."""
    robot = load_robot(find_shared('ur10e', 'robots'))
    load = LoadParameters(4.0, robot.rated_load.com, 0.015 * np.eye(3))
    motion = named_motion('pick_place', robot, 20.0, 0.7, 3)
    pipeline, due, estimate = build_pipeline('ur10e', 'lstm'), 0.0, None
    for event in simulate_motion(robot, motion.time, motion.position, motion.velocity,
                                 motion.acceleration, seed=1, run=3, start_temperature=18.0,
                                 load=load):
        if isinstance(event, TemperatureEvent):
            for joint, celsius in zip(robot.joints, event.celsius):
                pipeline.temperature_reading(joint, celsius)
        elif event.stamp >= due:
            due = event.stamp + 1.0 / 30.0 - 1e-4
            estimate = pipeline.joint_state(event.stamp, robot.joints, event.position,
                                            event.velocity, event.effort) or estimate
    assert pipeline.load_id == 0
    assert abs(estimate.mean[0] - 4.0) < 3.0 * estimate.std[0] < 0.15
