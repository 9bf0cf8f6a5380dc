"""Read an effects file: which hidden effects a plant has, on which joints and how strong."""

from dataclasses import dataclass, field

from ..errors import ConfigurationError
from ..files.configuration import read_yaml, Section
from .hidden import EFFECTS

_KEYS = 'name, joints (default: all), strength and/or parameters'


@dataclass(frozen=True)
class EffectRequest:
    """One entry: effect name, indices of its joints, strength or None, parameters, its place."""

    name: str
    joints: tuple
    strength: float | None
    parameters: dict = field(default_factory=dict)
    where: str = 'effects'


def read_effects(path, robot):
    """
    Return the EffectRequests of an effects file for a robot; raises ConfigurationError.

    `effects: [{name, joints, strength, parameters}]`. strength: RMS torque of the effect over
    the joint's torque noise along the reference motion (hidden/reference_motion.py), for
    effects of temperature 15 K above the reference temperature; effects that many joints feel
    count at the joint that feels them most. parameters: numbers, or lists with one number per
    listed joint; what is left open is drawn by the plant's seed.
    """
    content = read_yaml(path)
    section = Section(content, path)
    entries = section.get('effects', f'a list of {{{_KEYS}}}')
    section.refuse_unknown()
    return parse_effects(entries, robot, str(path))


def parse_effects(entries, robot, where='effects'):
    """Return the EffectRequests of a list of mappings; raises ConfigurationError."""
    if not isinstance(entries, list):
        raise ConfigurationError(where, 'effects is not a list', type(entries).__name__,
                                 f'a list of {{{_KEYS}}}')
    return tuple(_request(Section(entry, f'{where}: effects[{k}]'), robot,
                          f'{where}: effects[{k}]') for k, entry in enumerate(entries))


def _request(section, robot, where):
    name = section.text('name', tuple(EFFECTS))
    effect = EFFECTS[name]
    joints = tuple(range(robot.n))
    if section.has('joints'):
        names = section.names('joints')
        unknown = [joint for joint in names if joint not in robot.joints]
        if unknown:
            section.fail('joints', 'are not all joints of the robot', list(names),
                         ', '.join(robot.joints))
        if not effect.per_joint:
            section.fail('joints', f'cannot be chosen for {name}', list(names),
                         'nothing: it acts on the whole arm')
        joints = tuple(robot.joints.index(joint) for joint in names)
    strength = section.number('strength', 1e-3, 1e3) if section.has('strength') else None
    parameters = _parameters(section, effect, len(joints)) \
        if section.has('parameters') else {}
    section.refuse_unknown()
    if (strength is None) == (effect.amplitude not in parameters):
        raise ConfigurationError(where, f'{name} needs either a strength or its parameter '
                                 f'{effect.amplitude}, not both', strength,
                                 f'strength, or parameters: {{{effect.amplitude}: ...}}')
    return EffectRequest(name, joints, strength, parameters, where)


def _parameters(section, effect, joints):
    inner, raw = section.section('parameters'), section.get('parameters', 'a mapping')
    unknown = sorted(str(name) for name in set(raw) - set(effect.parameters))
    if unknown:
        known = ', '.join(f'{name} [{kind.unit}]' for name, kind in effect.parameters.items())
        section.fail('parameters', f'does not know {", ".join(unknown)}', raw, known)
    out = {}
    for name, kind in effect.parameters.items():
        if not inner.has(name):
            continue
        if kind.size > 1:
            out[name] = inner.vector(name, kind.size, kind.low, kind.high)
        elif isinstance(raw[name], list) and effect.per_joint:
            out[name] = inner.vector(name, joints, kind.low, kind.high)
        else:
            out[name] = inner.number(name, kind.low, kind.high)
    return out
