"""What has to be known of a torque model before it is relied on, whatever the arm does."""

from ..torque.simulated_model import told_of_simulated
from ..torque.unknown_friction import told_of_unknown_friction


def cautions(model, simulated):
    """Return sentences about a TorqueModel; simulated: whether the arm at work is."""
    return [text for text in (told_of_simulated(model, simulated),
                              told_of_unknown_friction(model)) if text]
