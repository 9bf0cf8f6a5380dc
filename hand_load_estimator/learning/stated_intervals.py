"""Make 95 % mean 95 % where a method states a deviation, and score it on other sequences."""

from dataclasses import dataclass

import numpy as np

from ..load import MESSAGE_ORDER
from .calibration import NORMAL_95, TOLD
from .features import REFRESH
from .objective import JUDGED
from .stated_factors import calibrated, LEAST_STD, RANGES

# The centre of a lighter load [kg] is nothing to be asked for.
WEIGHTLESS = 0.02


@dataclass(frozen=True)
class Answers:
    """
    What was answered on held-out sequences, in message order.

    errors, stds (cases, J, 10) at judged times, errors NaN where nothing is judged; severe
    (cases,): whether an undeclared effect stands out.
    """

    errors: np.ndarray
    stds: np.ndarray
    severe: np.ndarray


def judged_samples(steps):
    """Return the samples (J,) of a sequence of so many steps after which answers are judged."""
    last = np.array([(k + 1) * REFRESH - 1 for k in JUDGED])
    return last[last < steps]


def errors_of(mean, load, ends, begin):
    """
    Return the errors (cases, J, 10) of means after samples `ends` (J,), NaN where not judged.

    load (cases, 10) in message order; begin (cases,): sample in which the motion starts. Before
    it nothing is judged, nor ever the centre of a load that weighs nothing.
    """
    error = mean - load[:, None]
    error[ends[None] <= begin[:, None]] = np.nan
    error[load[:, 0] < WEIGHTLESS, :, 1:4] = np.nan
    return error


def calibrate_stated(answers, picked):
    """
    Return knots (P, RANGES) of log std and factors (P, RANGES) on it for 95 % coverage here.

    picked: places of the parameters. On arms without an undeclared effect that stands out, as
    calibration.calibrate.
    """
    healthy = ~answers.severe
    pairs = [factors_of(*(x[healthy][:, :, place].ravel()
                          for x in (answers.errors, answers.stds))) for place in picked]
    return tuple(np.array(part) for part in zip(*pairs))


def factors_of(error, std):
    """Return knots (RANGES,) and factors (RANGES,) from errors, NaN left out, and stated std."""
    std = np.maximum(std[np.isfinite(error)], LEAST_STD)
    ratio = np.abs(error[np.isfinite(error)]) / std
    parts = np.array_split(np.argsort(std, kind='stable'), RANGES)
    return ([np.median(np.log(std[part])) for part in parts],
            [np.quantile(ratio[part], 0.95) / NORMAL_95 for part in parts])


def scores_of(answers, picked, knots, factors):
    """Return coverage per parameter and the errors of mass and centre over time, for the card."""
    errors, severe = answers.errors, answers.severe
    inside = np.abs(errors) < NORMAL_95 * calibrated(answers.stds, picked, knots, factors)
    known, scores = np.isfinite(errors), {}
    for name, cases in (('', ~severe), ('_with_undeclared_effect', severe)):
        share = (inside & known)[cases].sum(axis=(0, 1)) \
            / np.maximum(known[cases].sum(axis=(0, 1)), 1)
        scores[f'coverage_of_95{name}'] = {
            MESSAGE_ORDER[k]: round(float(share[k]), 4) for k in picked}
    told = errors[:, [JUDGED.index(k) for k in TOLD]]
    if 0 in picked:
        scores['mass_rmse_kg'] = _over_time(np.sqrt(np.nanmean(told[..., 0] ** 2, axis=0)))
    if {1, 2, 3} <= set(picked):
        off = np.linalg.norm(told[..., 1:4], axis=-1)
        scores['centre_median_m'] = _over_time(np.nanmedian(off, axis=0))
    return scores


def coverage_over_time(answers):
    """Return {time: share within 95 %}, all parameters, arms without an undeclared effect."""
    told = [JUDGED.index(k) for k in TOLD]
    errors, stds = (x[~answers.severe][:, told] for x in (answers.errors, answers.stds))
    inside, known = np.abs(errors) < NORMAL_95 * stds, np.isfinite(errors)
    return _over_time(inside.sum(axis=(0, 2)) / np.maximum(known.sum(axis=(0, 2)), 1))


def _over_time(values):
    return {f'{(k + 1) / 10:g} s': round(float(value), 4) for k, value in zip(TOLD, values)}
