"""A learned correction in place of what is unknown is told with what it makes worse."""

from diagnosis_report_helpers import found
import numpy as np

from hand_load_estimator.residual.correction import with_correction
from hand_load_estimator.residual.diagnosis import Correction


def said(factors):
    """Return the sentence on a correction that changes the errors by so many times."""
    after = found().after * np.array(factors)
    told = with_correction(found(), Correction(None, after, after))
    assert told.remains[:-1] == found().remains
    return told.remains[-1]


def test_joints_that_got_worse_are_told_beside_those_that_got_better():
    text = said([1.0, 0.5, 1.0, 1.4, 1.01, np.nan])
    assert text.endswith('smaller with it: shoulder_lift_joint 3.1 -> 1.55 Nm; larger: '
                         'wrist_1_joint 0.71 -> 0.994 Nm')


def test_a_correction_that_changes_nothing_says_none():
    assert said(np.ones(6)).endswith('smaller with it: none; larger: none')


def test_without_a_correction_nothing_is_said():
    assert with_correction(found(), None).remains == found().remains
