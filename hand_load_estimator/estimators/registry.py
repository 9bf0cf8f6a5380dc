"""
The names of the ways of estimating, and how each is built.

Builders import what they need when called: torch only for methods that run it.
"""

from dataclasses import dataclass
from typing import Callable

from ..learning.direct_design import NETWORKS


@dataclass(frozen=True)
class Way:
    """
    One way of estimating.

    build(model, uncertainties, folder) -> Method; learned: which network its artefact holds
    (`network` of the card), or None for a method without one.
    """

    build: Callable
    learned: str | None = None


def _bayes(model, uncertainties, _):
    from .bayes import Bayes
    return Bayes(model, uncertainties)


def _lstm(model, uncertainties, folder):
    from ..learning.artefact import read_artefact
    from .lstm import Lstm
    return Lstm(model, uncertainties, read_artefact(folder, model.robot))


def _direct(network):
    def build(model, uncertainties, folder):
        from ..learning.direct_artefact import read_direct_artefact
        from .direct import Direct
        return Direct(model, uncertainties, read_direct_artefact(folder, model.robot, network))
    return Way(build, network)


METHODS = {
    'lstm': Way(_lstm, 'lstm'),
    'bayes': Way(_bayes),
    **{name: _direct(name) for name in NETWORKS}}
DEFAULT, WITHOUT_ARTEFACT = 'lstm', 'bayes'
