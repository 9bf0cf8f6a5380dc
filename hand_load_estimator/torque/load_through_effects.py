"""What a load adds to an arm whose model has effects that depend on the torque of its gears."""

import numpy as np

from ..effects import EffectInput
from ..effects.load_dependent_friction import direction
from ..effects.shown_gear import shown_side, shown_size
from .columns import torque_columns, warmth_of
from .shown_links import shown_links_and_way


def gear_with(model, x, products):
    """
    Return the torque (n,) [Nm] of a load, and gear, gear_way (n,) of EffectInput x with it.

    x holds one state; products (10,) of what is held.
    """
    robot = model.robot
    ways = [columns[0] for columns in shown_links_and_way(robot, x)]
    held = [robot.load_columns(columns) @ products for columns in ways]
    pulls = [pull[0] for pull in model.link_pull(x, products)]
    return held[0], [columns @ model.mean[:10 * robot.n] + torque + pull
                     for columns, torque, pull in zip(ways, held, pulls)]


def load_through_effects(model, columns, x, products, believed, gear):
    """
    Return Y (n, P), K (n, 10) and torque (n,): what a load does to effects that depend on torques.

    columns Y (n, P) without load, of EffectInput x of one state; products (10,) of what is thought
    to be held; believed, gear: of gear_with it. A wrong gain scales the load's torque too,
    friction grows with it, a leaning base turns its weight; what they may be off by grows with Y.
    LateRows adds what a delay does. The torque [Nm] is what the arm's own weight adds to friction
    where the load turns the gear's torque round: there |gear + load| is not |gear| and something.
    """
    load = model.robot.load_columns(columns[:, :model.layout.links])
    told, through, turned = columns.copy(), load.copy(), np.zeros(model.robot.n)

    def grow(joints, where, share, own):
        value = model.mean[where]
        told[joints, where] += share @ products + own
        through[joints] += value @ share
        turned[joints] += np.sum(value * own)

    for growth in _geared(model, columns, load, x, believed, gear):
        grow(*growth)
    # A gain misreads all that the drive gives.
    for growth in _scaled(model, x, through.copy(), turned.copy()):
        grow(*growth)
    return told, through, turned


def _geared(model, columns, load, x, believed, gear):
    """Yield (joints, where, share, own): Y[joints, where] grows by share @ products + own."""
    side = shown_side(*gear)
    bent = shown_size(*gear) - side * believed
    for use, where in model.slices():
        j = use.joint
        if use.name == 'load_dependent_friction':
            way = direction(x, j, use.shape)[0]
            yield j, where, side[j] * way * load[[j]], bent[j] * way - columns[j, where]
        elif use.name == 'base_tilt':
            tilted = model.robot.tilted_load_columns(x.q[0], model.mean[where])
            yield slice(None), where, tilted.swapaxes(0, 1), 0.0


def _scaled(model, x, through, turned):
    """Yield the same of gains, where a load adds through @ products + turned (n,) to drives."""
    for use, where in model.slices():
        j = use.joint
        if use.name == 'torque_scale':
            yield j, where, through[[j]], turned[j]
        elif use.name == 'torque_scale_temperature':
            yield j, where, x.warmth[0, j] * through[[j]], x.warmth[0, j] * turned[j]


def load_while_sliding(model, state, temperature, products):
    """
    Return K (n, 10) and torque (n,) of load_through_effects while sliding steadily, for planning.

    state: q, v, a (n,); temperature (n,) [degC], NaN where unknown; products (10,) of what is
    held.
    """
    if not model.layout.needs:
        return model.robot.load_regressor(*state), np.zeros(model.robot.n)
    rows = [np.asarray(row)[None] for row in (*state, warmth_of(model.robot, temperature))]
    x = EffectInput(*rows, np.sign(rows[1]))
    columns = torque_columns(model.robot, model.layout, x, model.mean)[0]
    return load_through_effects(model, columns, x, products, *gear_with(model, x, products))[1:]
