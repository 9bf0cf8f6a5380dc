"""What has changed by no more than the model says to expect: in the model written, no finding."""

import numpy as np

from ...effects import EFFECTS


def expected_changes(model, better, trace):
    """
    Return sentences on declared effects that were adapted to the recordings.

    model, better: TorqueModels before and after; trace: a finished Trace.
    """
    changes = [_change(model, better, hypothesis) for step in trace.drifted
               for hypothesis, _ in step.chosen.parts if hypothesis.name in EFFECTS]
    count = len(model.recordings)
    return [f'cannot tell whether {name} of {joint} has a cause ({told}), because a model '
            f'made from {count} recording{"s" * (count != 1)} says to expect as much; model.yaml '
            'has the change, and a model of more days and temperatures would tell'
            for name, joint, told in filter(None, changes)]


def _change(model, better, hypothesis):
    """Return effect, joint and in words how its parameters changed, None for what is no use."""
    old, new = (_values(m, hypothesis) for m in (model, better))
    if old is None or new is None:
        return None
    told = ', '.join(f'{parameter} {before:.3g} -> {after:.3g} {unit}' for (parameter, unit),
                     before, after in zip(EFFECTS[hypothesis.name].parameters, old, new))
    return hypothesis.name, model.robot.joints[hypothesis.joint], told


def _values(model, hypothesis):
    return next((np.asarray(model.mean[where]) for use, where in model.slices()
                 if (use.name, use.joint) == (hypothesis.name, hypothesis.joint)), None)
