"""The hypothesis of a base that leans, and of links that would look like it."""

from dataclasses import replace

import numpy as np

from ...effects import EFFECTS
from ...identification.identify import prior
from ...torque.columns import tilt_columns
from .hypothesis import beside_delays, EFFECT_FACTOR, Hypothesis, LINK_FACTOR


def tilted(model, residual):
    """Return the Hypothesis of a base that leans a little, to first order."""
    scale = EFFECT_FACTOR * EFFECTS['base_tilt'].std(1.0)
    return beside_delays(Hypothesis('base_tilt', 0, {
        j: residual.x.tilt()[:, j] * scale for j in range(model.robot.n)}, scale), residual)


def turned(hypothesis, score, model, residual):
    """
    Return base_tilt's Hypothesis with columns that are exact for the turn that its Score fitted.

    To first order only, a base that leans far leaves a torque which looks like other links.
    """
    before, turn = model.layout.tilt(model.mean), hypothesis.scale * score.theta
    now = np.concatenate([
        tilt_columns(model.robot, model.layout, residual.x.q[residual.owner == part], model.mean,
                     load.to_products(), turn) for part, load in enumerate(residual.loads)])
    # What the columns times both turns change, less what the model has of it already.
    columns = now + ((now - residual.x.tilt()) @ before)[..., None] * turn / (turn @ turn)
    return beside_delays(replace(hypothesis, prompt=None, columns={
        j: columns[:, j] * hypothesis.scale for j in hypothesis.columns}), residual)


def all_links(model, residual):
    """Return the Hypothesis that the data of all links are off, each as much as its own."""
    n = model.robot.n
    scale = LINK_FACTOR * np.sqrt(np.diag(prior(model.robot, (), True)[1]))[:10 * n]
    return beside_delays(Hypothesis('link_inertia', None, {
        j: residual.columns[:, j, :10 * n] * scale for j in range(n)}, scale), residual)
