"""What has to be known of a torque model before it is relied on, whatever the arm does."""

from ..simulated_model import told_of_simulated


def cautions(model, simulated):
    """Return sentences about a TorqueModel; simulated: whether the arm at work is."""
    return [text for text in (told_of_simulated(model, simulated), _told_of_friction(model))
            if text]


def _told_of_friction(model):
    """Return in words which joints' friction a TorqueModel does not know, or an empty string."""
    # Behind a torque sensor there is none to know.
    unknown = model.friction_doubt() > model.friction_level()
    names = ', '.join(name for name, is_unknown in zip(model.robot.joints, unknown) if is_unknown)
    return names and (f'the friction of {names} is not known, no recording moved it: a collision '
                      'there is seen late, and what it holds tells nothing of the load; identify '
                      'from a motion of all joints (hand_load excite)')
