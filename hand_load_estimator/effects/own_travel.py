"""Friction that turns over a travel of its own, not over that of the joint's other friction."""

import numpy as np

from .effect import Shape

# Contacts are springs: the larger a friction, the longer the way over which they bend (Canudas de
# Wit et al. 1995). Infinity: it turns as the joint's other friction; only a residual tells more.
OWN_TRAVEL = Shape('travel', 'rad', np.inf, (np.inf,), 25.0)
# [levels] From one level of friction to the other.
BOTH = 2.0
# The last of that way, over which contacts yield; before that they are a spring (Dupont et al.
# 2002). Where they yield all the way only a large effect tells more.
PLASTIC = Shape('plastic', '-', BOTH, (BOTH,), 25.0, least=0.05, most=BOTH)


def of_own_travel(x, j, shape, plain, *peak):
    """
    Return friction of size one (N,), or (N, m), where a travel is given, and `plain` elsewhere.

    x: EffectInput; peak: arguments of stribeck_curve.left behind the warmth, for friction that
    falls with speed.
    """
    # What falls with speed has to be followed, over whatever travel; other friction is z.
    own = np.isfinite(shape[OWN_TRAVEL.name]) | bool(peak)
    if x.shown is None or not np.any(own):
        return plain
    joints = np.arange(x.q.shape[1])[j]
    places = joints, shape[OWN_TRAVEL.name], shape.get(PLASTIC.name, BOTH), *peak
    if not np.ndim(joints) or np.all(own):
        return x.shown(*places)
    out = plain.copy()
    out[:, own] = x.shown(*(np.broadcast_to(place, joints.shape)[own] for place in places))
    return out
