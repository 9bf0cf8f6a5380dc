"""Is there time enough to diagnose, and if not: what took it away?"""

from ...errors import RecordingError
from ...stream.rejected_input import told_of_rejected
from ..outside.load_change import looks_loaded, NAME as LOAD_CHANGE

LEAST_SECONDS = 4.8    # twelve blocks of 0.4 s
# A load there for more than this share of a recording is likely to be one that was not declared.
LONG = 0.5
MANY = 0.05            # share of rejected messages that is worth a sentence


def names(evidence):
    """Return the names of recordings, Evidence or parts of it, each once."""
    return ', '.join(dict.fromkeys(e.name for e in evidence))


def refuse_too_short(left, evidence, residual=None, found=()):
    """
    Raise RecordingError where too little time is left, saying what took it away.

    left: Evidence, parts of recordings; evidence: the whole recordings; residual: their Residual
    and found: Disturbances in it.
    """
    seconds = sum(_seconds(e) for e in left)
    if seconds >= LEAST_SECONDS:
        return
    lost = [sentence for k, e in enumerate(evidence)
            for sentence in (*_taken(e, residual, [d for d in found if d.owner == k]),
                             *told_of_rejected(e))]
    rest = sum(map(_seconds, evidence)) - sum(_lasting(residual, d) for d in found) - seconds
    kept = [f'{rest:.1f} s are kept for the test or lie beside those'] if rest > 0.1 else []
    todo = [] if lost else ['record a motion of `hand_load excite`']
    raise RecordingError('; '.join([
        f'{names(evidence)}: {seconds:.1f} s are left to diagnose, of {LEAST_SECONDS:g} s of '
        'motion that are needed', *lost, *kept, *todo]))


def long_loads(evidence, residual, found):
    """Return a sentence on each load that is there for most of a recording without being said."""
    return [f'cannot tell whether {evidence[d.owner].name} declares the right load: for '
            f'{_lasting(residual, d):.0f} of its {_seconds(evidence[d.owner]):.0f} s it '
            f'{_load(evidence[d.owner], d)}' for d in found if d.cause.kind.name == LOAD_CHANGE
            and _lasting(residual, d) > LONG * _seconds(evidence[d.owner])]


def many_rejected(evidence):
    """Return a sentence on each recording of which much was not used."""
    return [f'cannot tell anything from what was not used: {sentence}' for e in evidence
            for sentence in told_of_rejected(e, MANY)]


def _seconds(evidence):
    return float(evidence.motion.dt.sum())


def _lasting(residual, disturbance):
    return float(residual.dt[disturbance.first:disturbance.stop].sum())


def _load(evidence, disturbance):
    return looks_loaded(evidence.load.mass + disturbance.theta[0], evidence.load.mass)


def _taken(evidence, residual, found):
    """Return sentences on what acted on the arm in a recording."""
    return [f'for {_lasting(residual, d):.1f} s {evidence.name} '
            + (_load(evidence, d) if d.cause.kind.name == LOAD_CHANGE
               else 'shows a contact; record without one') for d in found]
