"""Joints whose friction a torque model does not know, because no recording moved them."""


def told_of_unknown_friction(model):
    """Return in words which joints of a TorqueModel that are, or an empty string."""
    unmoved = model.residuals.unmoved
    # Behind a torque sensor there may be no friction to know.
    unknown = [] if unmoved is None else unmoved & (model.friction_doubt() > 0.0)
    names = ', '.join(name for name, is_unknown in zip(model.robot.joints, unknown) if is_unknown)
    return names and (f'the friction of {names} is not known, no recording moved it: what it '
                      'holds tells nothing of a load, and a collision there is seen late; '
                      'identify from a motion of all joints (hand_load excite)')
