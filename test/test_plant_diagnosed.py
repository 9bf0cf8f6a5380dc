"""The whole loop on the simulated arm: what is hidden in its physics comes out by name."""

from plant_helpers import effects, ur10e
import pytest

from hand_load_estimator.benchmark.cases import simulated
from hand_load_estimator.files.shared_files import find_shared
from hand_load_estimator.identification.evidence import prepare
from hand_load_estimator.load import LoadParameters
from hand_load_estimator.motion import Motion
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.diagnosis import CONFIRMED, UNKNOWN
from hand_load_estimator.seeds import SHIPPED_MODEL_PLANT
from hand_load_estimator.simulation.simulate_motions import named_motion
from hand_load_estimator.torque.model_file import read_model

# Motion and temperature [degC]; the last is kept for the test. The shipped model saw others.
RECORDED = (('excite', 20.0), ('pick_place', 40.0), ('excite', 32.0), ('excite', 28.0))
SECONDS, FIRST = 14.0, 40


@pytest.fixture(scope='module')
def model():
    return read_model(find_shared('ur10e', 'models'))


def found(model, *hidden):
    """Return the Diagnosis of the shipped model's arm with effects hidden in it."""
    robot, evidence = ur10e(), []
    for k, (name, celsius) in enumerate(RECORDED, start=FIRST):
        samples = simulated(robot, named_motion(name, robot, SECONDS, seed=k), run=k,
                            seed=SHIPPED_MODEL_PLANT, start_temperature=celsius, rate=250.0,
                            effects=effects(robot, *hidden))
        evidence.append(prepare(robot, f'run {k}', Motion.of(samples), LoadParameters()))
    return diagnose(model, evidence[:-1], evidence[-1:])[0]


def confirmed(diagnosis):
    return [(f.name, f.joints) for f in diagnosis.findings if f.verdict == CONFIRMED]


@pytest.fixture(scope='module')
def clean(model):
    return found(model)


def test_an_arm_as_it_was_has_nothing_new(clean):
    assert confirmed(clean) == []
    assert (clean.after < 1.05 * clean.before).all()


def test_two_effects_are_both_named_and_mended(model, clean):
    hidden = {'gravity_spring': 'shoulder_lift_joint', 'torque_ripple': 'elbow_joint'}
    diagnosis = found(model, *({'name': name, 'joints': [joint], 'strength': 5.0}
                               for name, joint in hidden.items()))
    assert dict(confirmed(diagnosis)) == {name: (joint,) for name, joint in hidden.items()}
    there = [ur10e().joints.index(joint) for joint in hidden.values()]
    assert (diagnosis.before[there] > 3.0 * clean.before[there]).all()
    assert (diagnosis.after < 1.15 * clean.before).all()


def test_friction_at_a_speed_has_no_name_and_is_told_with_its_variable(model):
    diagnosis = found(model, {'name': 'speed_resonance_friction', 'joints': ['wrist_2_joint'],
                              'strength': 5.0})
    (finding,) = [f for f in diagnosis.findings if f.verdict == CONFIRMED]
    assert finding.name == UNKNOWN and finding.joints == ('wrist_2_joint',)
    assert finding.variables == ('velocity',)
