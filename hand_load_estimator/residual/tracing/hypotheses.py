"""The hypotheses of one round: every effect on every joint, and plain functions."""

from dataclasses import replace
from itertools import product

import numpy as np

from ...effects import EFFECTS, LATE
from ...effects.knee import KNEE, shows
from ...effects.own_travel import BOTH, OWN_TRAVEL, PLASTIC
from ...effects.stribeck_friction import VELOCITY_RANGE
from ...identification.identify import prior
from ..diagnosis import UNKNOWN
from ..doubts.limits import SLOWEST_RATE
from ..measured.find import use_of
from .hypothesis import beside_delays, EFFECT_FACTOR, Hypothesis, LINK_FACTOR, searched
from .leaning_base import tilted
from .plain_functions import functions, VARIABLES
from .ripple import likely_periods

# Presliding may reach much further than a healthy gear's.
PRESLIDING_DISTANCES = (5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 0.016, 0.032, 0.064, 0.13, 0.26)
# And its contacts be springs for most of the way (presliding.Turning).
PLASTICS = (BOTH, 0.5)
# The travel that goes with other contacts is so many times longer, or shorter, than with these.
WITH_OTHERS = (0.8, 1.0, 1.25)
# Friction of an effect may turn over a travel of its own.
OWN_TRAVELS = (3e-4, 6e-4, 1.2e-3, 2.4e-3, 4.8e-3)
# Large ones tell more of their curves than the plainest: how a Stribeck peak falls (measured:
# exponents of 1.3) and warms, how much a lubricant thins.
FORMS = {'stribeck_friction': {'exponent': (1.0, 1.3, 1.7),
                               VELOCITY_RANGE.name: (np.inf, 80.0, 30.0)},
         'shear_thinning_friction': {'exponent': (1.0, 0.75, 0.5)}}
# These have one cause for all joints of an arm: one hypothesis, however many joints show it.
ONE_CAUSE = ('torque_scale', 'torque_scale_temperature', LATE)


def hypotheses(model, residual, blocks, warmed, done=()):
    """
    Yield every Hypothesis worth a trial on a Residual, but those whose keys are done.

    warmed: indices of joints whose temperature has changed enough to tell its effects.
    """
    for j in range(model.robot.n):
        yield from of_joint(model, residual, blocks, warmed, j, done)
    for name in ONE_CAUSE:
        if (name, None, '') not in done and _often(residual, name):
            yield from _late(_in_common(model, residual, EFFECTS[name], warmed), residual)
    if ('base_tilt', 0, '') not in done:
        yield tilted(model, residual)


def _often(residual, name):
    """Tell whether joint states come often enough to tell an effect."""
    return name != LATE or residual.interval * SLOWEST_RATE <= 1.0


def of_joint(model, residual, blocks, warmed, j, done=()):
    """Yield the Hypotheses of joint j alone; arguments as of hypotheses."""
    yield from _late(_of_joint(model, residual, blocks, warmed, j, done), residual)


def _late(found, residual):
    return (beside_delays(hypothesis, residual) for hypothesis in found)


def _of_joint(model, residual, blocks, warmed, j, done):
    residual.follow_friction(list(product(PRESLIDING_DISTANCES, PLASTICS)))
    for name, effect in EFFECTS.items():
        if effect.whole_arm or effect.learned or (name, j, '') in done \
                or not _seen(model, effect, j) or not _often(residual, name):
            continue
        if j in warmed or 'warmth' not in effect.needs:
            yield from _of_effect(model, residual, blocks, effect, j)
    if ('link_inertia', j, '') not in done:
        yield _of_link(residual, j, np.sqrt(np.diag(prior(model.robot, (), True)[1])))
    if not any((UNKNOWN, j, variable) in done for variable in VARIABLES):
        yield from functions(residual, model.robot.limits.torque, j)


def _seen(model, effect, j):
    """Tell whether the torque shows an effect: behind the gear, what is before it only if told."""
    return model.robot.effort.kind != 'link_torque' or effect.in_link_torque \
        or any((use.name, use.joint) == (effect.name, j) for use in model.uses)


def _of_effect(model, residual, blocks, effect, j):
    scale = EFFECT_FACTOR * effect.std(model.robot.limits.torque[j])
    if effect.name == 'presliding_hysteresis':
        # What turns in another way is the joint's Coulomb friction.
        level = EFFECT_FACTOR * EFFECTS['coulomb_friction'].std(model.robot.limits.torque[j])
        yield from _presliding(model, residual, j, level)
        return
    found = _shapes(model, effect, residual, blocks, j)
    columns_of = _columns(model, effect, residual.x, j, [shape for shape, _ in found])
    for (shape, count), columns in zip(found, columns_of):
        yield Hypothesis(effect.name, j, {j: columns * scale}, scale, shape, trials=count)


def _in_common(model, residual, effect, warmed):
    """Yield hypotheses of one effect with the same parameters on all joints that tell of it."""
    joints = [j for j in np.flatnonzero(residual.weights.any(axis=0)).tolist()
              if j in warmed or 'warmth' not in effect.needs]
    if len(joints) < 2:
        return
    scale = EFFECT_FACTOR * effect.std(model.robot.limits.torque[joints[0]])
    shapes = product(*([(shape.name, value) for value in shape.grid] for shape in effect.shapes))
    for shape in map(dict, shapes):
        columns = _side_by_side(effect, residual.x, joints, shape)
        yield Hypothesis(effect.name, None, {j: own * scale for j, own in columns.items()}, scale,
                         shape)


def _side_by_side(effect, x, joints, shape):
    """Return the columns {joint: (N, k)} of an effect with the same shape on several joints."""
    made = effect.columns(x, np.array(joints), {
        name: np.full(len(joints), value) for name, value in shape.items()})
    return {j: made[:, k] for k, j in enumerate(joints)}


def _shapes(model, effect, residual, blocks, j):
    """Return (shape, how many were looked at) pairs."""
    if not effect.shapes:
        return [({}, 1)]
    name = effect.shapes[0].name
    if name == 'periods':
        values, count = likely_periods(residual.x.q[:, j], residual.x.v[:, j],
                                       blocks.left_over(j), residual.weights[:, j])
        return [({name: float(value)}, count // len(values)) for value in values]
    names = [shape.name for shape in effect.shapes]
    grids = [_grid(model, residual, effect, shape, j) for shape in effect.shapes]
    return [(dict(zip(names, map(float, values))), 1) for values in product(*grids)]


def _grid(model, residual, effect, shape, j):
    """Return the values of a Shape to try: of knees also the model's, and those that show."""
    if shape is not KNEE:
        return shape.grid
    warmth = residual.x.warmth[residual.weights[:, j] > 0.0, j]
    shown = [knee for knee in shape.grid if knee == shape.default or shows(warmth, knee)]
    own = _bent(model, effect, j)
    if not own:
        return shown
    # Behind a straight line every knee would have to pay for itself again: it comes last.
    return [own[shape.name], *(knee for knee in reversed(shown) if knee != own[shape.name])]


def _bent(model, effect, j):
    """Return the shape {'knee': [K]} of an effect that the model has with a knee, or {}."""
    return next((use.told_shape for use in model.uses if (use.name, use.joint) == (effect.name, j)
                 and KNEE.name in use.told_shape), {})


def _columns(model, effect, x, j, shapes):
    """
    Return the columns (N, k) of an effect on joint j for each of several shapes.

    Of a knee elsewhere than the model's: what moving it there changes.
    """
    if 'play' not in effect.needs and OWN_TRAVEL not in effect.shapes:
        made, bent = [effect.columns(x, j, shape) for shape in shapes], _bent(model, effect, j)
        now = effect.columns(x, j, bent) if bent else 0.0
        return [columns if shape == bent else columns - now
                for shape, columns in zip(shapes, made)]
    # Gaps and travels are followed beside one another, in little more time than one of them.
    together = effect.columns(x, np.full(len(shapes), j), {
        name: np.array([shape[name] for shape in shapes]) for name in shapes[0]})
    return list(np.moveaxis(together, 1, 0))


def _presliding(model, residual, j, scale):
    """Yield hypotheses of another travel: the change of the friction state times a level."""
    now, bent = model.presliding_distance()[j], model.presliding_plastic()[j]
    for plastic, distance in product(PLASTICS, PRESLIDING_DISTANCES):
        if abs(np.log(distance / now)) < 0.3 and (plastic == BOTH) == (bent == BOTH):
            continue
        yield Hypothesis('presliding_hysteresis', j,
                         {j: _turning(residual, j, distance, plastic) * scale}, scale,
                         {'presliding_distance': distance, 'plastic': plastic})


def _turning(residual, j, distance, plastic):
    """Return the column (N, 1): change of joint j's friction state by another way of turning."""
    return (residual.friction_state(distance, plastic)[:, j] - residual.x.z[:, j])[:, None]


def reshaped(hypothesis, factors, model, residual):
    """
    Return Hypotheses with each of the nonlinear parameters multiplied by a factor.

    factors: for each of them a tuple of as many as `searched` returns.
    """
    there = searched(hypothesis).items()
    bounded = EFFECTS[hypothesis.name].bounded
    shapes = [bounded({**hypothesis.shape, **{
        name: value * factor for (name, value), factor in zip(there, those)}})
        for those in factors]
    return of_shapes(hypothesis, shapes, model, residual)


def of_shapes(hypothesis, shapes, model, residual):
    """Return the same Hypothesis with each of other shapes."""
    return list(_late(_of_shapes(replace(hypothesis, prompt=None), shapes, model, residual),
                      residual))


def _of_shapes(hypothesis, shapes, model, residual):
    j = hypothesis.joint
    if j is None:
        joints = list(hypothesis.columns)
        return [replace(hypothesis, shape=shape, columns={
            i: own * hypothesis.scale for i, own in _side_by_side(
                EFFECTS[hypothesis.name], residual.x, joints, shape).items()})
            for shape in shapes]
    if hypothesis.name == 'presliding_hysteresis':
        ways = [(shape['presliding_distance'], shape['plastic']) for shape in shapes]
        residual.follow_friction(dict.fromkeys(ways))
        columns = [_turning(residual, j, *way) for way in ways]
    else:
        columns = _columns(model, EFFECTS[hypothesis.name], residual.x, j, shapes)
    return [replace(hypothesis, columns={j: own * hypothesis.scale}, shape=shape)
            for own, shape in zip(columns, shapes)]


def other_forms(hypothesis, model, residual, warmed):
    """
    Return the Hypotheses that differ from one of FORMS in the form of its curve.

    warmed: whether the joint's temperature has changed enough to tell what it does.
    """
    here, velocity = hypothesis.shape, EFFECTS[hypothesis.name].shapes[0]
    # The velocity that goes with another form may be far from the one that goes with this.
    forms = {velocity.name: (here[velocity.name], *velocity.grid), **FORMS[hypothesis.name]}
    if not warmed:
        forms.pop(VELOCITY_RANGE.name, None)
    shapes = [{**here, **dict(zip(forms, values))} for values in product(*forms.values())]
    return of_shapes(hypothesis, [shape for shape in shapes if shape != here], model, residual)


def released(hypothesis, model, residual, warmed):
    """
    Return the Hypothesis with every figure of its form that stands at its default a little off it.

    From there on it is searched with all others; a list of one, or of none. warmed: as of
    other_forms.
    """
    figures = {**FORMS.get(hypothesis.name, {}), PLASTIC.name: PLASTICS}
    if not warmed:
        figures.pop(VELOCITY_RANGE.name, None)
    if not np.isfinite(hypothesis.shape.get(OWN_TRAVEL.name, 0.0)):
        # Of a travel that is not there.
        figures.pop(PLASTIC.name)
    free = {name: _a_little_off(*values[:2]) for name, values in figures.items()
            if hypothesis.shape.get(name) == values[0]}
    return of_shapes(hypothesis, [hypothesis.shape | free], model, residual) if free else []


def _a_little_off(default, other):
    """Return a third of the way from a default to another value, which may come from infinity."""
    return 3.0 * other if np.isinf(default) else default + (other - default) / 3.0


def other_ways(hypothesis, model, residual):
    """Return the Hypotheses that differ from one of `turns` in how friction turns."""
    if hypothesis.name == 'presliding_hysteresis':
        travel = hypothesis.shape['presliding_distance']
        ways = [{'presliding_distance': travel * factor, 'plastic': plastic}
                for plastic in PLASTICS if plastic != hypothesis.shape['plastic']
                for factor in WITH_OTHERS]
    else:
        ways = [{name: value for name, value in (('travel', travel), (PLASTIC.name, plastic))
                 if name in hypothesis.shape} for travel, plastic in product(
                     OWN_TRAVELS, PLASTICS if PLASTIC.name in hypothesis.shape else (BOTH,))]
    bounded = EFFECTS[hypothesis.name].bounded
    return of_shapes(hypothesis, [bounded(hypothesis.shape | way) for way in ways], model,
                     residual)


def _of_link(residual, j, std):
    where = slice(10 * j, 10 * j + 10)
    scale = LINK_FACTOR * std[where]
    return Hypothesis('link_inertia', j, {i: residual.columns[:, i, where] * scale
                                          for i in range(j + 1)}, scale)


def with_effect(uses, hypothesis, delays):
    """
    Return EffectUses that declare the hypothesis too, with its shape.

    delays: {joint: delay [s]} of the model that it was found with.
    """
    uses = list(uses)
    for k, use in enumerate(uses):
        if (use.name, use.joint) == (hypothesis.name, hypothesis.joint):
            shape = {**use.shape, **hypothesis.shape}
            if use.name == LATE:
                # What is found comes later still than the model says.
                shape['shift'] += delays.get(use.joint, 0.0)
            uses[k] = replace(use, shape=shape,
                              shape_std=use.shape_std if shape == use.shape else {})
            return tuple(uses)
    return (*uses, use_of(hypothesis.name, hypothesis.joint, hypothesis.shape))
