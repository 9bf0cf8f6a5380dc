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
    return held[0], [columns @ model.mean[:10 * robot.n] + torque
                     for columns, torque in zip(ways, held)]


def load_through_effects(model, columns, load, x, believed, gear):
    """
    Return K (n, 10) of a load as effects that depend on torques let it through, and torque (n,).

    columns Y (n, P), load K (n, 10) and EffectInput x of one state; believed, gear: of gear_with
    the load that is thought to be held. A wrong gain scales the load's torque too, friction grows
    with it, a leaning base turns its weight. LateRows adds what a delay does. The torque [Nm] is
    what the arm's own weight adds to friction where the load turns the gear's torque round: there
    |gear + load| is not |gear| and something.
    """
    robot, gain = model.robot, np.ones(model.robot.n)
    side = shown_side(*gear)
    bent = shown_size(*gear) - side * believed
    leaning, turned = np.zeros_like(load), np.zeros(robot.n)
    for use, where in model.slices():
        j, value = use.joint, model.mean[where]
        if use.name == 'torque_scale':
            gain[j] += value[0]
        elif use.name == 'torque_scale_temperature':
            gain[j] += value[0] * x.warmth[0, j]
        elif use.name == 'load_dependent_friction':
            against = value[0] * direction(x, j, use.shape)[0]
            gain[j] += side[j] * against
            turned[j] += bent[j] * against - value[0] * columns[j, where.start]
        elif use.name == 'base_tilt':
            leaning = np.einsum('a,ajk->jk', value,
                                robot.tilted_load_columns(x.q[0], value))
    return gain[:, None] * load + leaning, turned


def columns_with_load(model, columns, x, products, gear):
    """
    Return columns Y (1, n, P) as they are with a load of products (10,): what effects that depend
    on torques may be off by grows with it.

    columns: without, of EffectInput x; gear: of gear_with the load. A delay's stay.
    """
    robot, out = model.robot, columns.copy()
    held = robot.load_columns(columns[0, :, :10 * robot.n]) @ products
    for use, where in model.slices():
        j, k = use.joint, where.start
        if use.name == 'torque_scale':
            out[0, j, k] += held[j]
        elif use.name == 'torque_scale_temperature':
            out[0, j, k] += x.warmth[0, j] * held[j]
        elif use.name == 'load_dependent_friction':
            out[0, j, k] = shown_size(*gear)[j] * direction(x, j, use.shape)[0]
        elif use.name == 'base_tilt':
            out[0, :, where] += np.transpose(
                robot.tilted_load_columns(x.q[0], model.mean[where]) @ products)
    return out


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
    load = model.robot.load_columns(columns[:, :model.layout.links])
    return load_through_effects(model, columns, load, x, *gear_with(model, x, products))
