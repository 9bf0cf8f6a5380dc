"""
Make the intervals of a method without a network of its own true on held-out draws.

The method runs over the same kind of sequences that networks are calibrated on, sample by sample
as in the estimator, and its stated deviations get the factors that hold 95 % there.
"""

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch

from .. import seeds
from ..errors import ConfigurationError
from ..estimators.build import build_method
from ..estimators.registry import METHODS, with_network
from ..torque.model_file import read_model
from ..torque.model_follower import ModelFollower
from .artefact import arm_of
from .drawn_stream import drawn_stream
from .intervals import Intervals, kind_of, origin_of, write_intervals
from .sequences import DURATION
from .shards import read_shard
from .stated_factors import ALL
from .stated_intervals import (Answers, calibrate_stated, coverage_over_time, errors_of,
                               judged_samples, scores_of)
from .training_loop import begin_work, end_work, job_of, make_sequences


@dataclass(frozen=True)
class CalibrationRecipe:
    """method: name; learned: folder of what it learned, or None; numbers of sequences."""

    method: str
    learned: str | None = None
    calibration: int = 512
    validation: int = 256


@dataclass(frozen=True)
class MethodAnswers:
    """Makes shards of what a method answers on sequences, as of shards.write_shards."""

    method: str
    learned: str | None

    def __call__(self, maker, _, span):
        """Return {'error', 'std' (B, J, 10), 'severe' (B,)} of the sequences of a span."""
        errors, stds, severe = [], [], []
        for seed in span:
            sequence = maker.make(seed)
            mean, std, ends = self._answers(maker.model, sequence)
            errors.append(errors_of(mean[None], sequence.load[None].astype(float), ends,
                                    sequence.begin[None])[0])
            stds.append(std)
            severe.append(float(sequence.severe))
        return {name: torch.tensor(np.array(value)) for name, value in (
            ('error', errors), ('std', stds), ('severe', severe))}

    def _answers(self, model, sequence):
        """Return mean, std (J, 10) after the samples ends (J,)."""
        method = build_method(model, sequence.columns.shape[2] - 10, self.method, self.learned)
        ends = judged_samples(len(sequence.motion))
        told = set(ends.tolist())
        beliefs = []
        for k, (sample, prediction) in enumerate(drawn_stream(model.robot, sequence)):
            belief = method.update(sample, prediction)
            method.settle()
            if k in told:
                beliefs.append(belief)
        return (np.array([b.mean for b in beliefs]),
                np.sqrt(np.array([np.diagonal(b.covariance) for b in beliefs])), ends)


def calibrate_method(model_path, folder, recipe, write=print):
    """
    Write the Intervals of a CalibrationRecipe for the arm of a model into `folder`.

    Returns the scores on other sequences, with and without the factors. Work in progress lies in
    folder/work and is picked up by the next call with the same recipe, model and learned function.
    Raises ConfigurationError for a method that has its own calibration.
    """
    if recipe.method not in METHODS or with_network(recipe.method):
        raise ConfigurationError(
            '--method', 'is none whose intervals are calibrated apart', recipe.method,
            ', '.join(name for name in METHODS if not with_network(name)),
            'networks are calibrated when they are trained')
    began, model = time.time(), read_model(model_path)
    # Before the first of many sequences: what it learned may not fit the model.
    method = build_method(model, ModelFollower(model).uncertainties, recipe.method,
                          recipe.learned)
    # What was learned, too: another function may lie in the same folder by now.
    job = {**job_of(model_path, model, recipe), 'origin': origin_of(model, method)}
    spans = {'calibration': seeds.CALIBRATION[:recipe.calibration],
             'validation': seeds.VALIDATION[:recipe.validation]}
    work = begin_work(folder, job, spans)
    paths = make_sequences(model_path, work, spans,
                           MethodAnswers(recipe.method, recipe.learned), write)
    intervals = Intervals(*calibrate_stated(_read(paths['calibration']), ALL),
                          origin=job['origin'])
    scores = _scores(_read(paths['validation']), intervals,
                     np.sqrt(method.belief().covariance[0, 0]))
    write_intervals(folder, intervals, {
        'name': f'{kind_of(recipe.method)} for {model.robot.name}', **arm_of(model.robot),
        'network': kind_of(recipe.method),
        'calibrated_on': 'draws around the identified torque model; no simulator, no plant',
        'model_recordings': model.recording_names, **job, 'sequence_seconds': DURATION,
        'seeds': {name: span.start for name, span in spans.items()},
        'wall_seconds': round(time.time() - began), 'held_out': scores})
    end_work(work, paths)
    return scores


def _read(paths):
    """Return the Answers in shards at `paths`."""
    parts = [read_shard(Path(path), 'cpu') for path in paths]
    error, std, severe = (np.concatenate([part[name].numpy() for part in parts])
                          for name in ('error', 'std', 'severe'))
    return Answers(error, std, severe > 0.5)


def _scores(answers, intervals, before):
    """Return the scores of Answers with factors as Calibrated puts them, and without."""
    with_them = replace(answers, stds=answers.stds * intervals.of(answers.stds, before))
    stated = np.zeros_like(intervals.knots), np.ones_like(intervals.factors)
    return {**scores_of(with_them, ALL, *stated),
            'coverage_of_95_over_time': coverage_over_time(with_them),
            'coverage_of_95_as_stated': scores_of(answers, ALL, *stated)['coverage_of_95']}
