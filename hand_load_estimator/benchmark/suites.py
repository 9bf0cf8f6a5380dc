"""The accuracy suites: which cases each draws, on which plants, and why."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .. import seeds
from ..errors import ConfigurationError
from ..plant.hidden import EFFECTS
from .cases import Case, draw_case, draw_load, Recorded
from .effect_cases import EffectCase, Hidden, LOAD_CHANGE, place, SINGLE
from .wrist_swing import WRIST_SWING

# From this many cases on (the default method's coverage) plants are as many as here.
MANY_PLANTS = 50
CASES_PER_PLANT = 4
# Each hidden effect's turn comes so often in the undeclared suite.
CASES_PER_EFFECT = 4
UNDECLARED_STRENGTH = 2.0
# With another load in the hand than a case says, the case would be wrong and not the method.
UNDECLARED = [name for name in EFFECTS if name != LOAD_CHANGE]
# Loads of the inertia suite, for a rated load of 12.5 kg: mass [kg], half axes [m].
_HEAVY, _WIDE = (6.0, 10.0), (0.15, 0.2)
# Of the room suite [degC], and its recordings: at the start of a day, and warmed by work.
ROOM = 22.0
_IN_A_ROOM = (('excite', 22.0, 40.0), ('pick_place', 30.0, 40.0), ('excite', 38.0, 40.0),
              ('pick_place', 48.0, 40.0))


@dataclass(frozen=True)
class Suite:
    """
    One accuracy suite.

    about: a sentence for the page; draw(robot, plant, seed) -> Case; count: cases unless told;
    plants: of that count; plant_seeds, case_seeds: ranges; recorded: how its models were
    identified, temperatures told as in its cases; final_plants, final_cases: seeds of runs of
    more cases than count.
    """

    about: str
    draw: object
    count: int = 40
    plants: int = 10
    plant_seeds: range = seeds.BENCHMARK_PLANTS
    case_seeds: range = seeds.BENCHMARK_CASES
    recorded: Recorded = Recorded()
    final_plants: range = seeds.FINAL_PLANTS
    final_cases: range = seeds.FINAL_CASES


def draw_wide_case(robot, plant, seed):
    """Return the Case of a heavy, wide load and a motion that lets its inertia be felt."""
    rng = np.random.default_rng(seed)
    load = draw_load(robot, rng, _HEAVY, _WIDE, 0.05)
    return Case(plant, seed, load, rng.uniform(15.0, 50.0), 1.0, WRIST_SWING)


def draw_case_in_room(robot, plant, seed):
    """Return the Case of a warm arm in a room of ROOM."""
    return replace(draw_case(robot, plant, seed, (30.0, 50.0)), room=ROOM)


def draw_undeclared_case(robot, plant, seed):
    """
    Return the Case of an arm to which one hidden effect happened after its identification.

    Effects take turns by the seed; each acts on the first joint drawn that can have it so strong.
    Where none can (a small arm), the next effect's turn has come: no case is clean.
    """
    case = draw_case(robot, plant, seed)
    joints = tuple(int(j) for j in np.random.default_rng([seed, 5]).permutation(robot.n))
    first = seed % len(UNDECLARED)
    for name in UNDECLARED[first:] + UNDECLARED[:first]:
        order = joints if EFFECTS[name].per_joint else ()
        hidden = Hidden(name, UNDECLARED_STRENGTH, order)
        try:
            entries = place(robot, EffectCase(SINGLE, plant, (hidden,)))
        except ConfigurationError:
            continue
        return Case(plant, seed, case.load, case.temperature, case.speed, hidden=tuple(entries))
    raise ConfigurationError(f'plant {plant}', 'can have no effect so strong on any joint',
                             UNDECLARED_STRENGTH)


def recorded_words(suite):
    """Return in words which recordings a Suite's models are identified from."""
    seconds = [length for _, _, length in suite.recorded.motions]
    if len(seconds) == 1:
        return f'one {seconds[0]:g} s recording'
    return f'{len(seconds)} recordings of {sum(seconds):g} s in all'


SUITES = {
    'base': Suite('any load, temperature, speed and pick-and-place motion', draw_case, 200, 25),
    'development': Suite('the base suite on seeds for looking and choosing', draw_case, 64, 8,
                         seeds.DEVELOPMENT_PLANTS[50:], seeds.DEVELOPMENT_CASES),
    'cold': Suite('started at 15 to 20 degC; otherwise the cases of `warm`',
                  partial(draw_case, temperatures=(15.0, 20.0))),
    'warm': Suite('started at 40 to 50 degC', partial(draw_case, temperatures=(40.0, 50.0))),
    'slow': Suite('30 to 45 % of the quickest', partial(draw_case, speeds=(0.3, 0.45))),
    'fast': Suite('85 to 100 % of the quickest', partial(draw_case, speeds=(0.85, 1.0))),
    'sparse': Suite('any load, temperature, speed and pick-and-place motion; no temperature is '
                    'known, neither of the cases nor of the recording, pick and place at 25 degC',
                    draw_case, recorded=Recorded((('pick_place', 25.0, 20.0),), told=False)),
    'room': Suite('an arm that work has warmed to 30 to 50 degC in a room of '
                  f'{ROOM:g} degC, as in three of the four recordings of its model: sensors lag '
                  'behind the gears',
                  draw_case_in_room, recorded=Recorded(_IN_A_ROOM, room=ROOM)),
    'inertia': Suite('loads of 6 to 10 kg, 0.3 to 0.4 m across, wrists swinging above 10 rad/s^2',
                     draw_wide_case),
    'undeclared': Suite('one hidden effect of strength 2 since the identification (where no '
                        'joint of the arm can have it so strong, the next one)',
                        draw_undeclared_case, CASES_PER_EFFECT * len(UNDECLARED),
                        final_plants=seeds.FINAL_UNDECLARED_PLANTS,
                        final_cases=seeds.FINAL_UNDECLARED_CASES)}


def cases_of(suite, count=None, development=False):
    """
    Return (plant seed, [case seeds]) of `count` cases of a Suite, plant by plant.

    development: on seeds for looking and choosing instead of the benchmark's. More cases than the
    suite has by itself are on seeds that no smaller run has seen.
    """
    count = suite.count if count is None else count
    many = suite.plants if count <= suite.count else max(suite.plants, MANY_PLANTS)
    plants, own = suite.plant_seeds, suite.case_seeds
    if development:
        plants, own = seeds.DEVELOPMENT_PLANTS[50:], seeds.DEVELOPMENT_CASES
    elif count > suite.count and own == seeds.BENCHMARK_CASES:
        plants, own = suite.final_plants, suite.final_cases
    # A plant's identification costs as much as several cases: few cases share one.
    many = min(many, -(-count // CASES_PER_PLANT), len(plants))
    each = -(-count // many)
    parts = [list(own[k * each:min((k + 1) * each, count)]) for k in range(many)]
    return [(plant, part) for plant, part in zip(plants, parts) if part]
