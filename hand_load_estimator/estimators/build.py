"""Put a Pipeline together from files, as nodes and commands name them."""

import hashlib
import json
from pathlib import Path

from ..errors import ConfigurationError
from ..learning import difference_artefact
from ..learning.artefact import CARD, read_artefact
from ..model_file import model_digest, read_model
from ..model_follower import ModelFollower
from ..robot import load_robot
from ..shared_files import find_shared, share_folder
from ..tool import read_tool, ToolFollower
from .bayes import Bayes
from .difference_function import DifferenceFunction
from .gp_bayes import GpBayes
from .gp_histogram import GpHistogram
from .gp_search import GpAnnealing, GpEvolution, GpSwarm
from .lstm import Lstm
from .pipeline import Pipeline

# A parameter counts as determined below these standard deviations, as fractions of the rated
# mass, in metres, and as a fraction of the rated load's largest moment of inertia.
DETERMINED = (0.01, 0.01, 0.1)


def determined_std(robot):
    """Return the thresholds for mass [kg], centre of mass [m] and inertia [kg m^2]."""
    rated = robot.rated_load
    moment = max(float(rated.inertia.diagonal().max()), 1e-3 * rated.mass)
    return DETERMINED[0] * rated.mass, DETERMINED[1], DETERMINED[2] * moment


def shipped_artefact(robot):
    """Return the folder of the artefact shipped for a robot's joints and effort kind, or None."""
    for card in sorted((share_folder() / 'config' / 'learned').glob(f'*/{CARD}')):
        try:
            content = json.loads(card.read_text(encoding='utf-8'))
        except ValueError as error:
            raise ConfigurationError(card, f'is not JSON ({error})',
                                     todo='install the package again') from None
        if content.get('joints') == list(robot.joints) \
                and content.get('effort_kind') == robot.effort.kind:
            return card.parent
    return None


def shipped_difference(model):
    """Return the folder of the torque difference shipped for a TorqueModel, or None."""
    digest = model_digest(model)
    learned = share_folder() / 'config' / 'learned'
    for card in sorted(learned.glob(f'*/{difference_artefact.CARD}')):
        if json.loads(card.read_text(encoding='utf-8')).get('model') == digest:
            return card.parent
    return None


def _bayes(model, uncertainties, learned):
    if learned:
        raise ConfigurationError('learned', 'goes with methods that learn, not with bayes',
                                 learned)
    return Bayes(model, uncertainties)


def _lstm(model, uncertainties, learned):
    folder = Path(learned) if learned else shipped_artefact(model.robot)
    if folder is None:
        return Bayes(model, uncertainties)
    return Lstm(model, uncertainties, read_artefact(folder, model.robot))


def _on_difference(method):
    """Return the builder of a Method class that takes a DifferenceFunction."""
    def build(model, uncertainties, learned):
        folder = Path(learned) if learned else shipped_difference(model)
        if folder is None:
            raise ConfigurationError(f'method {method.name}', 'needs a learned torque difference '
                                     'of this model, and none is shipped',
                                     todo=difference_artefact.AGAIN + ' and give it as learned')
        artefact = difference_artefact.read_difference(folder, model)
        return method(model, uncertainties, DifferenceFunction(model, artefact))
    return build


# Methods on a learned torque difference of one model.
ON_DIFFERENCE = {method.name: method for method in (
    GpHistogram, GpBayes, GpSwarm, GpEvolution, GpAnnealing)}
# name -> builder(model, uncertainties, learned folder or None) of a Method
METHODS = {'lstm': _lstm, 'bayes': _bayes,
           **{name: _on_difference(method) for name, method in ON_DIFFERENCE.items()}}


def build_method(model, uncertainties, name, learned=None):
    """
    Return the Method of a name for a TorqueModel.

    learned: artefact folder, or None for the shipped one; without any, `lstm` becomes `bayes`
    and the method's name says so, while methods on a learned torque difference fail.
    """
    if name not in METHODS:
        raise ConfigurationError('method', 'is not known', name, ', '.join(METHODS))
    return METHODS[name](model, uncertainties, learned)


def _check_robot(model, path, robot):
    own = model.robot
    if own.joints != robot.joints or own.effort.kind != robot.effort.kind:
        raise ConfigurationError(
            f'model {path}', 'belongs to another robot',
            f'{own.name}: {", ".join(own.joints)}; {own.effort.kind}',
            f'{robot.name}: {", ".join(robot.joints)}; {robot.effort.kind}')


def build_pipeline(model_path, method='lstm', learned=None, robot_path=None, tool_path=None):
    """
    Return the Pipeline of a model file; raises ConfigurationError.

    robot_path: robot file the model must belong to, by joints and effort kind, or None;
    tool_path: load file of a known tool, or None: the estimate is what is held beside it.
    """
    model_file = find_shared(model_path, 'models')
    model = read_model(model_file)
    if robot_path is not None:
        _check_robot(model, model_path, load_robot(find_shared(robot_path, 'robots')))
    follower, tool = ModelFollower(model), None
    if tool_path:
        tool = read_tool(tool_path)
        follower = ToolFollower(follower, tool)
    return Pipeline(model, follower,
                    build_method(model, follower.uncertainties, method, learned or None),
                    determined_std(model.robot), model_file=model_file,
                    digest=hashlib.sha256(model_file.read_bytes()).hexdigest(),
                    tool=tool)
