"""Is a torque model the shipped one, of a simulated arm? Its recordings tell, wherever it lies."""

# Content of the recordings (recording_mark.py) that config/models/ur10e.yaml was identified from.
SHIPPED = frozenset(('424fd973e7f01b96', 'c79fcb17f5d77fb6', 'a0db5ab8092a3006',
                     '904cf417ecc88ff8', 'f1682fbed9030f6f'))


def told_of_simulated(model, simulated):
    """
    Return in words that a TorqueModel is of a simulated arm, or an empty string.

    simulated: whether the arm at work is, too.
    """
    if simulated or not SHIPPED & {mark.content for mark in model.recordings}:
        return ''
    return ('the torque model that comes with the package is of a simulated arm: identify your '
            'own (hand_load identify), or set use_sim_time where the arm is simulated')
