"""A hypothesis: one possible cause of the residual, and what may be asked of it."""

from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import EFFECTS, LATE, PRESLIDING
from ...effects.own_travel import OWN_TRAVEL
from ..doubts.impossible import SURE
from ..doubts.wrong_joint import LEAST_GAIN, MOST_GAIN

# Units of columns, beside the prior's std: link data may be off by more than a new arm's.
LINK_FACTOR, EFFECT_FACTOR = 3.0, 3.0
# A delay delays the whole torque: its share is 1 within this, or a little more when in doubt.
WHOLE, DOUBTFUL = 0.35, 0.5


@dataclass(frozen=True)
class Hypothesis:
    """
    One possible cause: name, joint index (None: the same on several), columns {joint: (N, k)} in
    units of the prior's std.

    scale (k,): that std in physical units; shape: values of nonlinear parameters; variable: for
    `unknown`, what it is a function of; trials: how many shapes were looked at to come to it;
    prompt: the columns as they are without the delays of the joints, where those are among them.
    """

    name: str
    joint: int | None
    columns: dict
    scale: np.ndarray
    shape: dict = field(default_factory=dict)
    variable: str = ''
    trials: int = 1
    prompt: dict | None = None

    @property
    def key(self):
        """What makes it a cause of its own, whatever its shape."""
        return self.name, self.joint, self.variable

    def at(self, j):
        """Return the same of one of several joints."""
        return replace(self, joint=j, columns={j: self.columns[j]},
                       prompt=self.prompt and {j: self.prompt[j]})


def beside_delays(hypothesis, residual):
    """
    Return a Hypothesis with the columns that it has beside the delays of a Residual.

    A joint whose torque comes late shows late whatever else it does.
    """
    prompt = hypothesis.prompt or hypothesis.columns
    delayed = hypothesis.prompt or residual.delays.keys() & prompt.keys()
    if hypothesis.name == LATE or not delayed:
        return hypothesis
    return replace(hypothesis, columns=residual.reported(prompt), prompt=prompt)


def searched(hypothesis):
    """Return the nonlinear parameters {name: value} that are there (Shape.there)."""
    return EFFECTS[hypothesis.name].told(hypothesis.shape) if hypothesis.shape else {}


def turns(hypothesis):
    """Tell whether a shape of a Hypothesis says how friction turns after a reversal."""
    return hypothesis.name == 'presliding_hysteresis' or (
        hypothesis.name in EFFECTS and OWN_TRAVEL in EFFECTS[hypothesis.name].shapes)


def looks_like_another(hypothesis):
    """Tell whether a shape stands at an end, beyond which no motion shows what it is."""
    there = searched(hypothesis)
    return any(s.longest(there[s.name]) or s.slowest(there[s.name])
               for s in EFFECTS[hypothesis.name].shapes if s.name in there) if there else False


def whole(share, std):
    """Tell whether the share of a delay, with its standard deviation, may be a whole."""
    return bool(abs(share - 1.0) < np.clip(3.0 * std, WHOLE, DOUBTFUL))


def price(hypothesis, other):
    """Return the nats that a Hypothesis must gain beyond another of its key, of plainer shape."""
    return sum(shape.gain for shape in EFFECTS[hypothesis.name].shapes
               if other.shape[shape.name] == shape.default != hypothesis.shape[shape.name]
               ) if hypothesis.shape else 0.0


def physical(hypothesis, score, declared):
    """
    Tell whether the fitted parameters are what the effect's physics allows.

    declared: mean and std (k,) of the model's parameters where it has the effect already, so that
    only their change was fitted, or None.
    """
    if hypothesis.name not in EFFECTS:
        return True
    theta, std = score.theta, np.sqrt(np.diag(score.covariance))
    if hypothesis.name == 'torque_scale':
        gain = 1.0 + theta[0] * hypothesis.scale[0] + (0.0 if declared is None else declared[0][0])
        return bool(LEAST_GAIN < gain < MOST_GAIN)
    if hypothesis.name == PRESLIDING:
        # What turns in another way is a share of the joint's friction.
        return bool(theta[0] > SURE * std[0])
    if declared is not None:
        total, doubt = (theta + declared[0] / hypothesis.scale,
                        np.hypot(std, declared[1] / hypothesis.scale))
        # With another shape it is no change of what was there.
        return bool(hypothesis.shape) or not any(
            total[k] < -SURE * doubt[k] for k in EFFECTS[hypothesis.name].positive)
    positive = all(theta[k] > SURE * std[k] for k in EFFECTS[hypothesis.name].positive)
    if hypothesis.name == LATE:
        share, doubt = theta[0] * hypothesis.scale[0], std[0] * hypothesis.scale[0]
        return whole(share, doubt)
    return positive
