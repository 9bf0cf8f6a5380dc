"""How much of a recording's input was not used, and why."""

# Reasons that are not about a joint state: it is used in spite of them, or it was a temperature.
_NO_STATE = ('gap', 'clock_restart', 'implausible_temperature', 'zero_temperature',
             'temperature_expired')


def joint_states_of(rejected):
    """Return those of counts {reason: count} that are of joint states not used."""
    return {reason: count for reason, count in rejected.items() if reason not in _NO_STATE}


def share_rejected(evidence):
    """
    Return the share of the joint states of an Evidence's recording that were rejected.

    A state that is published again with its stamp is no loss.
    """
    count = sum(number for reason, number in joint_states_of(evidence.rejected).items()
                if reason != 'repeated_stamp')
    return count / max(count + _used(evidence), 1)


def in_words(rejected):
    """Return counts {reason: count} in words, most first."""
    return ', '.join(f'{number} {reason.replace("_", " ")}' for reason, number in
                     sorted(rejected.items(), key=lambda item: -item[1]))


def told_of_rejected(evidence, least=0.0):
    """Return [a sentence on the input that was not used], [] if it is no more than a share."""
    # A driver's zeros for temperatures it does not measure are no messages that something broke.
    rejected = {reason: count for reason, count in evidence.rejected.items()
                if reason != 'zero_temperature'}
    count = sum(rejected.values())
    if count <= least * (count + _used(evidence)):
        return []
    return [f'{count} of {count + _used(evidence)} messages of {evidence.name} were rejected '
            f'({in_words(rejected)}); look at them with `hand_load check`']


def _used(evidence):
    return int(evidence.motion.messages.sum())
