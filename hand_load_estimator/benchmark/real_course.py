"""What a method said all along a measured run: what the estimate at its end does not show."""

from dataclasses import asdict, dataclass

import numpy as np

# Later than this after motion start [s] every sample is judged, not single moments only.
JUDGED_FROM = 1.0


@dataclass(frozen=True)
class Course:
    """
    One method's course over the samples of one run.

    changes: load changes counted, None of a method that counts none; worst [kg]: largest |mass
    error| later than JUDGED_FROM; inside [-]: share of those samples whose 95 % interval holds
    the truth; both None where the run is shorter; mismatch [-]: share of all samples with
    MODEL_MISMATCH, None of a method that never says it.
    """

    changes: int | None
    worst: float | None
    inside: float | None
    mismatch: float | None


class CourseOf:
    """Follow the course of one Contestant; truth: the mass held [kg]."""

    def __init__(self, truth):
        self._truth, self._samples, self._errors, self._inside = truth, 0, [], []

    def update(self, belief, late):
        """Take a sample's Belief; late: it comes later than JUDGED_FROM."""
        self._samples += 1
        if late:
            error = abs(float(belief.mean[0]) - self._truth)
            self._errors.append(error)
            self._inside.append(error <= 1.96 * np.sqrt(belief.covariance[0, 0]))

    def told(self, contestant):
        """Return as a dict the Course of the Contestant whose beliefs these were."""
        says = hasattr(contestant.method, 'mismatch')
        return asdict(Course(
            getattr(contestant.method, 'changes', None), max(self._errors, default=None),
            float(np.mean(self._inside)) if self._inside else None,
            contestant.mismatches / max(self._samples, 1) if says else None))
