"""The learned artefact beside a better torque model: fine-tuned from it and judged on loads."""

from dataclasses import replace

from ..learning import training
from ..learning.artefact import read_artefact
from .diagnosis import FineTuning
from .load_error import load_error


def with_fine_tuning(diagnosis, better, model_path, start, folder, runs, progress):
    """
    Return the Diagnosis with what became of an artefact.

    better: the better TorqueModel, written to model_path; start, folder: of the artefact and of
    what is made of it; runs: (Evidence, Recording, LoadParameters), of which the loaded ones are
    estimated with method `lstm`, the better model and either artefact.
    """
    training.train(model_path, folder, training.FINE_TUNING, write=progress, start_from=start,
                   made_by='diagnose')
    old, new = (read_artefact(path, better.robot) for path in (start, folder))
    return replace(diagnosis, fine_tuning=FineTuning(
        old.card.get('name', ''), load_error(better, runs, old), load_error(better, runs, new)))
