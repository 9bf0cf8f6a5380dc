"""Recordings without what acted from outside, traced: the Trace and the models to compare."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import RecordingError
from ..identification.evidence import between_gaps
from ..identification.identify import prior
from .add import better_model
from .doubts.known_recordings import made_from
from .doubts.limits import refuse_the_useless, still_joints, usable_residual, warmed_joints
from .doubts.time_left import refuse_too_short
from .doubts.unknown import left_over
from .measured.find import Residual
from .outside.disturbance_findings import at
from .outside.outside import Outside, outside_again, outside_of
from .tracing.trace import Trace

# Times that recordings are traced again without what only the better model has shown.
AGAIN = 2


@dataclass(frozen=True)
class Explanation:
    """
    What a trace says of the parts of recordings in which nothing acted from outside.

    whole: Residual of the whole recordings by the model diagnosed; outside: Outside left out;
    evidence, test: Evidence fitted and tested on; residual: of evidence by the model diagnosed;
    steps: what the better model has; still: {joint index: why it tells nothing}; warmed: indices
    of joints whose temperature changed enough, and sentences on the others; rest (N, n) [Nm]: what
    the trace leaves; old, better: TorqueModels to compare with, and with what was found; refitted:
    whether old was fitted without the test; seen: Residual of the whole recordings by the better
    model and Disturbances in it; unused: sentences on those that were not left out.
    """

    whole: Residual
    outside: Outside
    evidence: tuple
    test: tuple
    residual: Residual
    steps: tuple
    still: dict
    warmed: tuple
    trace: Trace
    rest: np.ndarray
    old: object
    better: object
    refitted: bool
    seen: tuple
    unused: tuple = ()


def explain(model, recordings, test, progress):
    """
    Return the Explanation of recordings, Evidence each, by a TorqueModel; test: Evidence given.

    A push that a strong effect hid shows once that effect is known: what is new then is left out,
    too, and the rest traced once more. Raises RecordingError where too little time is left at
    first.
    """
    progress('looking for contacts and changes of the load')
    whole, _ = usable_residual(model, recordings)
    first = outside_of(model, recordings, whole)

    def explained(outside):
        parts = _explained(model, recordings, whole, outside, test, progress)
        # Where nothing else is found, what only another model showed is not seen again.
        return replace(parts, seen=(whole, first.found) if parts.better is model
                       else outside_again(parts.better, recordings))
    found, why = explained(first), f'the search ends after {AGAIN + 1} times'
    for _ in range(AGAIN):
        news = _news(found, recordings)
        if not news:
            break
        progress('once more without what the better model shows from outside')
        try:
            found = explained(found.outside.joined(found.seen[0], news))
        except RecordingError as error:
            why = f'without it {error}'
            break
    return replace(found, unused=tuple(
        f'cannot tell what the model written would be without the {one.cause.kind.name} that it '
        f'shows in {recordings[one.owner].name}{at(one)} because {why}; diagnose again with the '
        'model written, or with more recordings' for one in _news(found, recordings)))


def _news(found, recordings):
    """Return the Disturbances that the better model alone shows."""
    return found.outside.hidden(recordings, found.seen[1])


def _explained(model, recordings, whole, outside, test, progress):
    """Return the Explanation of recordings without an Outside, as yet with nothing `seen`."""
    evidence, tested = outside.parts(recordings, whole, test)
    refuse_too_short(evidence, recordings, whole, outside.found)
    refuse_the_useless(model, evidence)
    evidence, tested = between_gaps(evidence), between_gaps(tested)
    warmed = warmed_joints(model, evidence)
    progress('computing the residual')
    # Where nothing was left out it is that of the whole recordings.
    residual, still = (whole, still_joints(model, evidence)) if _rows(evidence) == _rows(
        recordings) else usable_residual(model, evidence)
    own = made_from(model, evidence)
    trace = _traced(model, residual, warmed[0], own, progress)
    # What is found first is no noise: only the rest tells how much there is.
    noisy = residual.as_noisy_as(left_over(model.robot, trace.blocks), model.residuals.intensity)
    if noisy is not residual:
        progress('once more, as noisy as these recordings are')
        residual, trace = noisy, _traced(model, noisy, warmed[0], own, progress)
    progress('estimating everything together')
    misled = own and bool(outside.found)
    refitted = own and not test and bool(trace.steps or outside.found)
    # What the model says to expect of other days is no finding, and of this day all the same. Of
    # its own recordings it is an average.
    steps = trace.steps if own else [*trace.steps, *trace.drifted]
    old, better = _models(model, steps, evidence, misled, refitted)
    return Explanation(whole, outside, evidence, tested, residual, tuple(steps), still, warmed,
                       trace, left_over(model.robot, trace.blocks), old, better, refitted, ())


def _rows(evidence):
    return [len(e.torque) for e in evidence]


def _traced(model, residual, warmed, own, progress):
    """Return the Trace, done."""
    trace = Trace(model, residual, warmed, _root(model) if own else None, progress)
    trace.run()
    trace.keep_what_still_gains()
    return trace


def _root(model):
    """Return the square root (P, P) of what parameters may be before any recording."""
    return np.sqrt(prior(model.robot, model.uses, model.links_declared)[1])


def _models(model, steps, evidence, misled, refitted):
    """
    Return TorqueModels: to compare with, and with what was found.

    misled: whether the model took what acted from outside for the arm's own; refitted: whether it
    was made from what is now kept for the test.
    """
    if not steps and not misled:
        return model, model
    # Where another is written both are fitted without the test; else the error told is that of
    # the model written.
    old = better_model(model, (), evidence) if refitted else model
    return old, better_model(model, steps, evidence)
