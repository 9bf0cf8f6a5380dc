"""Behind a joint torque sensor nothing is looked for that the sensor cannot see."""

from dataclasses import replace

from core_helpers import four_axes
import numpy as np
import pytest
from residual_helpers import (clean_runs, declared_model, Hidden, noise_of, on, recorded, SECONDS,
                              viscous)

from hand_load_estimator.benchmark.real_sets import SETS
from hand_load_estimator.effects import EFFECTS
from hand_load_estimator.identification.evidence import Evidence
from hand_load_estimator.residual.diagnose import diagnose
from hand_load_estimator.residual.measured.find import find_residual
from hand_load_estimator.residual.tracing.hypotheses import hypotheses
from hand_load_estimator.torque.columns import torque_columns

SENSOR = {'kind': 'link_torque', 'includes_configured_load': False}
UNSEEN = {name for name, effect in EFFECTS.items() if not effect.in_link_torque}


def behind_a_sensor(names):
    """Return the model of the arm with sensors behind its gears and effects of those names."""
    return replace(declared_model(names=names), robot=four_axes(effort=SENSOR))


def tried(model):
    residual = find_residual(model, recorded())
    return {(h.name, h.joint) for h in hypotheses(model, residual, residual.blocks(),
                                                   warmed=range(model.robot.n))}


def test_effects_of_motor_and_gear_are_not_tried_behind_a_sensor():
    found = {name for name, _ in tried(behind_a_sensor(('torque_offset',)))}
    assert not found & UNSEEN
    assert {'gravity_spring', 'cable_drag', 'torque_ripple', 'time_delay', 'base_tilt',
            'link_inertia', 'unknown'} <= found
    assert UNSEEN & {name for name, _ in tried(declared_model())}


def test_of_those_the_model_declares_a_change_is_tried():
    model = behind_a_sensor(('coulomb_friction', 'torque_offset'))
    found = tried(model)
    assert {name for name, _ in found} & UNSEEN == {'coulomb_friction'}
    assert {joint for name, joint in found if name == 'coulomb_friction'} == set(range(4))


def test_friction_that_a_sensor_cannot_see_has_no_name():
    model, rng, evidence = behind_a_sensor(('torque_offset',)), np.random.default_rng(3), []
    for k, (x, motion, _) in enumerate(clean_runs(SECONDS)):
        torque = torque_columns(model.robot, model.layout, x) @ model.mean
        hidden = on(2, 8.0, viscous)(Hidden(model.robot, x, motion, torque))
        noise = rng.normal(size=torque.shape) * noise_of(model.robot)
        evidence.append(Evidence(f'run {k}', motion, torque + hidden + noise))
    diagnosis, _ = diagnose(model, evidence[:-1], evidence[-1:])
    assert [(f.name, f.joints, f.variables) for f in diagnosis.findings] == [
        ('unknown', (model.robot.joints[2],), ('velocity',))]


@pytest.mark.parametrize('name', SETS)
def test_every_measured_set_starts_from_coulomb_and_viscous_friction(name):
    friction = {'coulomb_friction', 'viscous_friction'}
    sensors = name in ('panda', 'lwr4')
    # A sensor behind the gear sees the link's own friction, and no rotor.
    assert set(SETS[name].effects) & UNSEEN == (friction if sensors
                                                else friction | {'rotor_inertia'})
