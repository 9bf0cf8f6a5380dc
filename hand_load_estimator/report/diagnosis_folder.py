"""The folder of a diagnosis: what is written there, and what an earlier one has left."""

from ..files.output_file import output_folder
from ..learning.artefact import CARD, SCHEMA as LEARNED, WEIGHTS
from ..torque.model_file import SCHEMA as MODEL
from .diagnosis_json import SCHEMA as REPORT
from .diagnosis_page import MARK

_CARD, _WEIGHTS = f'learned/{CARD}', f'learned/{WEIGHTS}'
_STALE = {'report.html': MARK, 'report.json': REPORT, 'model_with_correction.yaml': MODEL,
          _CARD: LEARNED}


def diagnosis_folder(path, inputs):
    """Return a path as Path; ConfigurationError where a diagnosis must not write there."""
    return output_folder(path, {'model.yaml': MODEL, **_STALE}, inputs)


def clear(folder):
    """
    Remove what an earlier diagnosis has left, but for an unfinished training.

    Its model stays until the next takes its place: a node may read it.
    """
    # Without a card beside them nobody knows whose the weights are.
    weights = (_WEIGHTS,) if (folder / _CARD).exists() else ()
    for name in (*_STALE, *weights):
        (folder / name).unlink(missing_ok=True)
