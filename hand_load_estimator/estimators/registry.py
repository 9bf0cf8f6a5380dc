"""
The names of the ways of estimating, and how each is built.

Builders import what they need when called: torch only for methods that run it.
"""

from dataclasses import dataclass
from typing import Callable

from ..learning.direct_design import NETWORKS

DIFFERENCE = 'difference'


@dataclass(frozen=True)
class Way:
    """
    One way of estimating.

    build(model, uncertainties, folder) -> Method; learned: which network its artefact holds
    (`network` of the card), DIFFERENCE for a learned torque difference, or None for neither.
    """

    build: Callable
    learned: str | None = None


def _bayes(model, uncertainties, _):
    from .bayes import Bayes
    return Bayes(model, uncertainties)


def _least_squares(model, uncertainties, _):
    from .least_squares import LeastSquares
    return LeastSquares(model, uncertainties)


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


def _on_difference(name):
    def build(model, uncertainties, folder):
        from ..learning.difference_artefact import read_difference
        from .difference_function import DifferenceFunction
        from .gp_bayes import GpBayes
        from .gp_histogram import GpHistogram
        from .gp_search import GpAnnealing, GpEvolution, GpSwarm
        methods = {method.name: method
                   for method in (GpHistogram, GpBayes, GpSwarm, GpEvolution, GpAnnealing)}
        function = DifferenceFunction(model, read_difference(folder, model))
        return methods[name](model, uncertainties, function)
    return Way(build, DIFFERENCE)


METHODS = {
    'lstm': Way(_lstm, 'lstm'),
    'bayes': Way(_bayes),
    'least_squares': Way(_least_squares),
    **{name: _direct(name) for name in NETWORKS},
    **{name: _on_difference(name) for name in (
        'gp_histogram', 'gp_bayes', 'gp_swarm', 'gp_evolution', 'gp_annealing')}}


def with_network(name):
    """Tell whether a method has a network, whose training calibrates its intervals."""
    return METHODS[name].learned not in (None, DIFFERENCE)


DEFAULT, WITHOUT_ARTEFACT = 'lstm', 'bayes'
ON_DIFFERENCE = frozenset(name for name, way in METHODS.items() if way.learned == DIFFERENCE)
