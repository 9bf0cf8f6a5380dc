"""
Identify a torque model from recordings without load, or with a known one (eq. 11).

Weighted regularised least squares around the nominal parameters:
x = x_nom + (sum Y^T W Y + P0^-1)^-1 sum Y^T W (tau - Y x_nom), where P0 says how far nominal link
data may be off and how large an effect may be, and W is the inverse spectral density of the
residual, so that coloured residuals do not pass for knowledge.
"""

import numpy as np

from ..effects import DEFAULT_EFFECTS, EFFECTS, NEEDS_TEMPERATURE
from ..errors import ConfigurationError, RecordingError
from ..torque.columns import EffectUse, effect_slices, parameter_count
from ..torque.sliding import moved_joints
from ..torque_model import Residuals, TorqueModel
from .evidence import between_gaps
from .knee_fit import with_knees_fitted
from .left_out_noise import noise_left_out
from .load_agreement import share_left_out
from .regression_system import held_out, System
from .residual_noise import density, known_joints, rmse_of, sliding_left, with_usual_drift
from .shape_search import search_shapes

# How far a link's published mass, and its first and second moments, may be off.
LINK_DOUBT = 0.1
# Turns in which knees and the travels that go with them may settle.
SETTLING = 3
# Below this much usable motion [s] there is nothing to identify from.
LEAST_MOTION = 3.0


def prior(robot, uses, links_declared, known=None):
    """
    Return the nominal x (P,) and its covariance P0 (P, P, diagonal).

    known (n,) bool: joints whose temperature is, or None for all. Of the others nothing that
    warmth does is looked for: it would stay as doubtful as it was, and be the largest doubt.
    """
    n = robot.n
    mean = np.zeros(parameter_count(n, uses))
    mean[:10 * n] = robot.nominal_links
    std = np.zeros_like(mean)
    if links_declared:
        for j in range(n):
            m, first = mean[10 * j], mean[10 * j + 1:10 * j + 4]
            reach = np.linalg.norm(first) / max(m, 1e-9) + 0.05
            std[10 * j] = LINK_DOUBT * m
            std[10 * j + 1:10 * j + 4] = LINK_DOUBT * m * reach
            std[10 * j + 4:10 * j + 10] = LINK_DOUBT * m * reach ** 2
        # A massless link would fix its own parameters; let it be as doubtful as a small one.
        std[:10 * n] = np.maximum(std[:10 * n], 1e-5)
    for use, where in effect_slices(n, uses):
        std[where] = use.effect.std(robot.limits.torque[use.joint])
        if known is not None and not known[use.joint]:
            std[[where.start + k for k in use.effect.of_warmth]] = 0.0
    return mean, np.diag(std ** 2)


def check_effects(names):
    """Raise ConfigurationError for names of effects that cannot be declared."""
    known = ('link_inertia', *EFFECTS)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ConfigurationError('--effects', 'names unknown effects', ', '.join(unknown),
                                 ', '.join(known))
    searched = [name for name in names
                if name in EFFECTS and any(not s.grid for s in EFFECTS[name].shapes)]
    if searched:
        raise ConfigurationError('--effects', 'names effects whose shape only a residual tells',
                                 ', '.join(searched), todo='find them with `hand_load diagnose`')


def declare(robot, names, known):
    """
    Return (uses, links_declared) for effect names; all joints, default shapes.

    known (n,) bool: joints whose temperature is; only these have effects of it.
    """
    names = DEFAULT_EFFECTS if names is None else names
    check_effects(names)
    chosen = [EFFECTS[name] for name in names if name in EFFECTS]
    if robot.effort.kind == 'link_torque' and names is DEFAULT_EFFECTS:
        chosen = [e for e in chosen if e.in_link_torque]
    uses = tuple(EffectUse(e.name, j) for j in range(robot.n) for e in chosen
                 if not (e.whole_arm and j) and (known[j] or e.name not in NEEDS_TEMPERATURE))
    return uses, 'link_inertia' in names


def identify(robot, evidence, effects=None, progress=lambda text: None, drifting=True):
    """
    Return the TorqueModel identified from a list of Evidence.

    effects: names to declare, or None for the default list; drifting: whether offset and friction
    may differ between recordings, which plain least squares does not know of. Raises
    ConfigurationError for unknown effects and RecordingError when the recordings hold too little
    motion.
    """
    evidence = between_gaps(evidence)
    temperatures = np.concatenate([e.motion.temperature for e in evidence])
    known = np.isfinite(temperatures).any(axis=0)
    uses, links_declared = declare(robot, effects, known)
    _require_motion(evidence)
    mean, covariance = prior(robot, uses, links_declared, known)
    intensity = (0.01 * robot.limits.torque) ** 2 * 0.02
    friction = 0.03 * robot.limits.torque
    x = mean
    for turn in range(4):
        progress(f'identification pass {turn + 1} of 4')
        if turn in (1, 2):
            uses = search_shapes(robot, uses, evidence, x, intensity, friction,
                                 again=turn == 2)
        system = System(robot, uses, evidence, x)
        weights = system.weights(intensity, friction)
        x, posterior = system.solve(mean, covariance, weights)
        intensity = density(system.residual(x), weights, system.owner, system.dt)
        friction = TorqueModel(robot, uses, links_declared, x, posterior, None).held_friction()
    searched = uses
    for _ in range(SETTLING):
        uses, x, _ = with_knees_fitted(system, uses, searched, mean, covariance, weights)
        if system.levels_hold(uses, x):
            break
        system = System(robot, uses, evidence, x)
        weights = system.weights(intensity, friction)
    intensity, drift = noise_left_out(system, (mean, covariance), weights, friction)
    system, stated = (system.with_drift(drift) if drifting else system,
                      system.weights(intensity, friction))
    uses, x, posterior = with_knees_fitted(system, uses, searched, mean, covariance, stated)
    left_out = held_out(system, mean, covariance, stated)
    unjudged = TorqueModel(robot, uses, links_declared, x, posterior, None)
    # What no recording shows is no part of what loads found in them suffer from.
    share = share_left_out(system, left_out, stated, drift)
    moved, told = moved_joints(evidence), known_joints(evidence)
    residuals = Residuals(rmse_of(unjudged, system, left_out.residual, moved), intensity,
                          with_usual_drift(unjudged, system, drift, told),
                          sliding_left(system, left_out), share, ~moved)
    seen = temperatures[np.isfinite(temperatures)]
    return TorqueModel(robot, uses, links_declared, x, posterior, residuals,
                       tuple(dict.fromkeys(e.mark for e in evidence)),
                       (float(seen.min()), float(seen.max())) if known.any() else None)


def _require_motion(evidence):
    moving = sum(float(e.motion.dt[np.abs(e.motion.v).max(axis=1) > 0.02].sum())
                 for e in evidence)
    if moving < LEAST_MOTION:
        raise RecordingError(
            f'{", ".join(dict.fromkeys(e.name for e in evidence))}: hold {moving:.1f} s of '
            f'motion; at least {LEAST_MOTION:g} s are needed; record a motion of '
            '`hand_load excite`')


def nominal_model(robot, noise_intensity):
    """Return the robot file's own model: nominal links, no effects (a baseline's model)."""
    mean, _ = prior(robot, (), False)
    residuals = Residuals(np.sqrt(noise_intensity / 0.02), np.asarray(noise_intensity),
                          np.zeros((robot.n, 3)))
    return TorqueModel(robot, (), False, mean, np.zeros((len(mean), len(mean))), residuals)
