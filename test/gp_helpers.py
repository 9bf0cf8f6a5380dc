"""Methods on the learned difference in a pipeline, and the load that their tests carry."""

from core_helpers import block, warm
from difference_helpers import model

from hand_load_estimator.estimators.build import build_method, determined_std
from hand_load_estimator.estimators.pipeline import Pipeline
from hand_load_estimator.torque.model_follower import ModelFollower

LOAD = block(2.0)


def pipeline(name, learned):
    """Return a fresh Pipeline of a method."""
    follower = ModelFollower(model())
    method = build_method(model(), follower.uncertainties, name, learned)
    return warm(Pipeline(model(), follower, method, determined_std(model().robot)))
