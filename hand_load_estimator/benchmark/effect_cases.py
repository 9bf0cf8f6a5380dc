"""Which undeclared effects are tried: alone, in pairs, none at all, and some no model knows."""

from dataclasses import dataclass

import numpy as np

from .. import seeds
from ..errors import ConfigurationError
from ..plant import Plant
from ..plant.effects_file import parse_effects
from ..plant.hidden import EFFECTS
from .effect_truth import true_change

SINGLE, PAIR, CLEAN, OUTSIDE = 'single', 'pair', 'clean', 'outside'
# None at all, and nobody recorded the temperatures.
BLIND = 'blind'
ALONE = 'alone'           # clean, and one recording is all there is
# One effect of the same size on all joints, and two on one joint.
COMMON, SAME_JOINT = 'common', 'same_joint'
# Effects of the plant that no model knows, and the variable that a report has to name, one of
# them. A swing follows no variable of the arm: it rings in time, with its own frequency.
NOT_IN_VOCABULARY = {'speed_resonance_friction': ('velocity',), 'swinging_load': ('time',),
                     'saturating_drive': ('drive torque', 'gear torque')}
CONTACT, LOAD_CHANGE = 'external_contact', 'load_change'
# What comes from outside is in the recordings that errors are taken on, too, and no model of the
# arm can foretell it.
FROM_OUTSIDE = (CONTACT, LOAD_CHANGE)
STRENGTHS = (0.5, 2.0, 5.0)
MEDIUM = 2.0             # from here on the goals count
REPEATS = 2
PAIRS, PAIR_STRENGTH = 12, 3.0
OUTSIDE_REPEATS, OUTSIDE_STRENGTH = 6, 3.0
ON_ALL = ('torque_scale', 'torque_scale_temperature', 'time_delay')
SAME_JOINTS = 8
PLANTS = 20
_BENCHMARK = seeds.FINAL_EFFECT_PLANTS
_DEVELOPMENT = seeds.DEVELOPMENT_PLANTS[40:40 + PLANTS]
# Development loads of this suite lie behind those of the others.
_FIRST_LOAD = 50_000


@dataclass(frozen=True)
class Hidden:
    """An effect to hide: name, strength, joint indices in the order they are tried (or none)."""

    name: str
    strength: float
    joints: tuple = ()


@dataclass(frozen=True)
class EffectCase:
    """One diagnosis: kind, plant seed, what is hidden in the plant."""

    kind: str
    plant: int
    hidden: tuple = ()

    @property
    def label(self):
        """A name of its own, fit for a file."""
        parts = [f'{h.name}_{h.strength:g}' for h in self.hidden]
        return '-'.join([self.kind, *parts, str(self.plant)])


def plants_of(development=False):
    """Return the plant seeds of this suite."""
    return _DEVELOPMENT if development else _BENCHMARK


def suite_cases(robot, development=False):
    """
    Return all EffectCases for a robot, those of one plant together.

    development: the same on plants and loads that are for looking and choosing.
    """
    plants = plants_of(development)
    cases = [*_singles(robot, plants), *_pairs(robot, plants), *_outside(robot, plants),
             *_common(plants), *_same_joint(robot, plants),
             *(EffectCase(kind, plant) for kind in (CLEAN, BLIND, ALONE) for plant in plants)]
    return sorted(cases, key=lambda case: case.plant)


def _singles(robot, plants):
    names = [name for name in EFFECTS if name not in NOT_IN_VOCABULARY]
    wanted = [(name, strength) for name in names for strength in STRENGTHS
              for _ in range(REPEATS)]
    return [_single(SINGLE, robot, plants[k % len(plants)], name, strength, k)
            for k, (name, strength) in enumerate(wanted)]


def _outside(robot, plants):
    wanted = [name for name in NOT_IN_VOCABULARY for _ in range(OUTSIDE_REPEATS)]
    return [_single(OUTSIDE, robot, plants[k], name, OUTSIDE_STRENGTH, k)
            for k, name in enumerate(wanted)]


def _single(kind, robot, plant, name, strength, k):
    rng = np.random.default_rng([plant, k])
    return EffectCase(kind, plant, (Hidden(name, strength, _joints(robot, name, rng)),))


def _joints(robot, name, rng):
    if not EFFECTS[name].per_joint:
        return ()
    return tuple(int(j) for j in rng.permutation(robot.n))


def _common(plants):
    wanted = [(name, strength) for name in ON_ALL for strength in STRENGTHS[1:]]
    return [EffectCase(COMMON, plants[-1 - k], (Hidden(*those),))
            for k, those in enumerate(wanted)]


def _pairs(robot, plants):
    out = []
    for plant in plants[:PAIRS]:
        rng = np.random.default_rng([plant, PAIRS])
        out.append(EffectCase(PAIR, plant, tuple(
            Hidden(name, PAIR_STRENGTH, _joints(robot, name, rng)) for name in _two(rng))))
    return out


def _same_joint(robot, plants):
    out = []
    for plant in plants[-SAME_JOINTS:]:
        rng = np.random.default_rng([plant, SAME_JOINTS])
        names, joints = _two(rng), tuple(int(j) for j in rng.permutation(robot.n))
        out.append(EffectCase(SAME_JOINT, plant, tuple(
            Hidden(name, PAIR_STRENGTH, joints) for name in names)))
    return out


def _two(rng):
    names = [name for name, effect in EFFECTS.items()
             if effect.per_joint and name not in NOT_IN_VOCABULARY]
    return [str(name) for name in rng.choice(names, 2, replace=False)]


def place(robot, case):
    """
    Return the entries of an effects file for a case, each effect on a joint of its own.

    The first joint in order on which the effect can be so strong is taken, in a SAME_JOINT case
    the first for all of them; in a COMMON case all joints have the size at which the one that
    feels it most does so as strongly as stated. Raises ConfigurationError when there is none.
    """
    if case.kind == COMMON:
        return [_on_all(robot, case.plant, *case.hidden)]
    if case.kind == SAME_JOINT:
        return _on_one(robot, case)
    entries = []
    for hidden in case.hidden:
        entries.append(_entry(robot, case.plant, hidden, entries))
    return entries


def _entry(robot, plant, hidden, others):
    if not hidden.joints:
        return {'name': hidden.name, 'strength': hidden.strength}
    taken = [joint for other in others for joint in other.get('joints', ())]
    for joint in hidden.joints:
        placed = _at(robot, hidden, joint)
        if robot.joints[joint] not in taken and _possible(robot, plant, [placed]):
            return placed
    raise _too_strong(plant, hidden)


def _on_one(robot, case):
    for joint in case.hidden[0].joints:
        placed = [_at(robot, hidden, joint) for hidden in case.hidden]
        if _possible(robot, case.plant, placed):
            return placed
    raise _too_strong(case.plant, case.hidden[0])


def _on_all(robot, plant, hidden):
    amplitude = EFFECTS[hidden.name].amplitude
    each = [_at(robot, hidden, joint) for joint in range(robot.n)]
    sizes = [true_change(robot, plant, entry)[amplitude] for entry in each
             if _possible(robot, plant, [entry])]
    if not sizes:
        raise _too_strong(plant, hidden)
    return {'name': hidden.name, 'joints': list(robot.joints),
            'parameters': {amplitude: min(sizes)}}


def _at(robot, hidden, joint):
    return {'name': hidden.name, 'strength': hidden.strength, 'joints': [robot.joints[joint]]}


def _possible(robot, plant, entries):
    """Tell whether a plant can have these entries of an effects file."""
    try:
        Plant(robot, seed=plant, effects=parse_effects(entries, robot))
    except ConfigurationError:
        return False
    return True


def _too_strong(plant, hidden):
    return ConfigurationError(f'plant {plant}', f'{hidden.name} cannot be so strong on any joint',
                              hidden.strength)


def load_seeds(plant, count):
    """Return `count` seeds of loaded runs for a plant of this suite; other plants', others."""
    if plant in _BENCHMARK:
        own, first = seeds.FINAL_EFFECT_CASES, count * _BENCHMARK.index(plant)
    else:
        own = seeds.DEVELOPMENT_CASES
        first = _FIRST_LOAD + count * seeds.DEVELOPMENT_PLANTS.index(plant)
    return own[first:first + count]
