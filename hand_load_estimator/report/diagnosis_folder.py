"""The folder of a diagnosis: what is written there, and what an earlier one has left."""

import json

from ..errors import ConfigurationError
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
    folder = output_folder(path, {'model.yaml': MODEL, **_STALE}, inputs)
    if (folder / _CARD).exists() and not _own(folder / _CARD):
        raise ConfigurationError(folder / _CARD, 'is of an artefact that no diagnosis made',
                                 todo='give another --out')
    return folder


def _own(card):
    """Tell whether a card is of what a diagnosis fine-tuned."""
    try:
        content = json.loads(card.read_text(encoding='utf-8'))
    except ValueError:
        return False
    return isinstance(content, dict) and content.get('made_by') == 'diagnose'


def clear(folder):
    """
    Remove what an earlier diagnosis has left, but for an unfinished training.

    Its model stays until the next takes its place: a node may read it.
    """
    # Without a card beside them nobody knows whose the weights are.
    weights = (_WEIGHTS,) if (folder / _CARD).exists() else ()
    for name in (*_STALE, *weights):
        (folder / name).unlink(missing_ok=True)
