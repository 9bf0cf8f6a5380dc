"""
Figures of a hidden effect beside what a better model says of it.

Everything is compared as a change: of the plant by the effect, of the model by the diagnosis. So
a model that had Coulomb friction is asked how much came to it, and a ripple is counted from none.
"""

import numpy as np

from ..effects.own_travel import BOTH
from ..plant import Plant
from ..plant.effects_file import parse_effects
from ..plant.hidden.gear import Gap
from ..plant.plant import Situation


def _of_joint(field, part=None):
    """Return a reader of a per-joint field of the truth, or of one of its parts."""
    def read(plant, joint):
        """Return the field of a Plant's joint, in the unit of the effect's parameter."""
        holder = plant.truth if part is None else getattr(plant.truth, part)
        return float(getattr(holder, field)[joint])
    return read


def _tilt(plant, _):
    gravity = np.array(plant.truth.gravity)
    nominal = np.array(plant.robot.file.gravity)
    cosine = gravity @ nominal / np.linalg.norm(gravity) / np.linalg.norm(nominal)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _gain(plant, joint):
    return float(plant.truth.effort_gain[joint] - 1.0)


def _round_turn(plant, joint):
    """Return the spectrum of the hidden torque over one turn of a joint: amplitudes by period."""
    if not plant.truth.joint_torques:
        return np.zeros(1025)
    now, count = Situation(plant.robot.n), 2048
    torque = []
    for angle in 2.0 * np.pi * np.arange(count) / count:
        now.position = np.zeros(plant.robot.n)
        now.position[joint] = angle
        torque.append(sum(t.torque(now, 1e-3) for t in plant.truth.joint_torques)[joint])
    return np.abs(np.fft.rfft(torque)) * 2.0 / count


def _amplitude(plant, joint):
    return float(np.max(_round_turn(plant, joint)[1:]))


def _periods(plant, joint):
    spectrum = _round_turn(plant, joint)
    return float(np.argmax(spectrum[1:]) + 1) if spectrum.any() else 0.0


def _gap(plant, joint):
    return float(sum(own.gap[joint] for own in plant.truth.joint_torques if isinstance(own, Gap)))


def _held_mass(plant, _):
    return sum(held.load.mass for held in plant.truth.held)


def _swing(plant, _):
    return sum(force.frequency for force in plant.truth.forces)


def _push(plant, _):
    return float(sum(np.linalg.norm(force.at_most) for force in plant.truth.forces))


# effect: {parameter of the report: the same of the plant}. Effects whose form differs in the two
# (cable, asymmetry, a point mass against ten products of which motion shows sums) have no common
# figure.
COMPARABLE = {
    'rotor_inertia': {'inertia': _of_joint('rotor')},
    'base_tilt': {'angle': _tilt},
    'gravity_spring': {'stiffness': _amplitude}, 'backlash': {'travel': _gap},
    'coulomb_friction': {'level': _of_joint('coulomb', 'friction')},
    'viscous_friction': {'coefficient': _of_joint('viscous_rest', 'friction')},
    'stribeck_friction': {'level': _of_joint('static', 'friction')},
    'load_dependent_friction': {'coefficient': _of_joint('load_share', 'friction')},
    'temperature_dependent_viscous_friction': {'slope': _of_joint('viscous_slope', 'friction')},
    'temperature_dependent_coulomb_friction': {'slope': _of_joint('coulomb_slope', 'friction')},
    'presliding_hysteresis': {'travel_of_reversal': _of_joint('presliding', 'friction')},
    'torque_ripple': {'amplitude': _amplitude, 'periods': _periods},
    'torque_scale': {'gain': _gain},
    'torque_scale_temperature': {'slope': _of_joint('effort_gain_slope')},
    'torque_offset': {'level': _of_joint('effort_offset')},
    'time_delay': {'delay': _of_joint('effort_delay')},
    'external_contact': {'force': _push}, 'load_change': {'mass': _held_mass},
    'swinging_load': {'frequency': _swing}}
# No part of the model: what is said of them stands in the report only.
IN_REPORT_ONLY = ('external_contact', 'load_change', 'swinging_load')


def true_change(robot, plant_seed, entry):
    """Return {parameter: value} an effects file's entry adds to a plant, where comparable."""
    joint = _joint_of(robot, entry)
    new = Plant(robot, seed=plant_seed)
    changed = Plant(robot, seed=plant_seed, effects=parse_effects([entry], robot))
    return {name: read(changed, joint) - read(new, joint)
            for name, read in COMPARABLE.get(entry['name'], {}).items()}


def model_change(robot, before, after, entry):
    """Return {parameter: value} by which two TorqueModels differ in the effect of an entry."""
    if entry['name'] in IN_REPORT_ONLY:
        return {}
    joint = _joint_of(robot, entry)
    old, new = (_figures(model, entry['name'], joint) for model in (before, after))
    return {name: new.get(name, 0.0) - old.get(name, 0.0)
            for name in COMPARABLE.get(entry['name'], {})}


def stated(finding, parameter):
    """
    Return (mean, std) that a finding of report.json states of a parameter; None where it has none.

    Of what the model had before, the report states the change beside the new value.
    """
    told = finding['parameters']
    figure = told.get(f'change_of_{parameter}', told.get(parameter))
    return (None, None) if figure is None else (figure['mean'], figure['std'])


def _joint_of(robot, entry):
    return robot.joints.index(entry['joints'][0]) if entry.get('joints') else 0


def _figures(model, name, joint):
    """Return {parameter: value} of an effect of a model, shapes and derived figures included."""
    for use, where in model.slices():
        if use.name != name or not (use.effect.whole_arm or use.joint == joint):
            continue
        values = model.mean[where]
        out = {p: float(v) for (p, _), v in zip(use.effect.parameters, values)}
        out.update({shape: float(v) for shape, v in use.shape.items()})
        if use.effect.derived:
            derived = use.effect.derived(values, use.shape)
            out.update({p: float(v) for p, (v, _) in derived.items()})
        if name == 'presliding_hysteresis':
            out['travel_of_reversal'] = _reversal(**use.shape)
        return out
    return {}


def _reversal(presliding_distance, plastic=BOTH):
    """Return the travel [rad] from one level to 95 % of the other; presliding.Turning solved."""
    sprung, yielding = (BOTH - plastic) / plastic, np.log(plastic / 0.05)
    return presliding_distance * (sprung + yielding) * 2.0 * BOTH * plastic / (
        BOTH ** 2 + plastic ** 2)
