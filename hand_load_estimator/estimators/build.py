"""Put a Pipeline together from files, as nodes and commands name them."""

import hashlib
import json

from ..errors import ConfigurationError
from ..files.shared_files import find_shared, share_folder
from ..learning import difference_artefact
from ..learning.artefact import CARD, NETWORK, network_of, not_of
from ..learning.intervals import kind_of, origin_of, read_intervals
from ..load import MESSAGE_ORDER
from ..robot import load_robot
from ..torque.model_file import model_digest, read_model
from ..torque.model_follower import ModelFollower
from ..torque.model_of_robot import model_of_robot
from .calibrated import Calibrated
from .pipeline import Pipeline
from .registry import DEFAULT, DIFFERENCE, METHODS, with_network, WITHOUT_ARTEFACT
from .tool import read_tool, ToolFollower

# A parameter counts as determined below these standard deviations, as fractions of the rated
# mass, in metres, and as a fraction of the rated load's largest moment of inertia.
DETERMINED = (0.01, 0.01, 0.1)


def determined_std(robot):
    """Return the thresholds for mass [kg], centre of mass [m] and inertia [kg m^2]."""
    rated = robot.rated_load
    moment = max(float(rated.inertia.diagonal().max()), 1e-3 * rated.mass)
    return DETERMINED[0] * rated.mass, DETERMINED[1], DETERMINED[2] * moment


def shipped_artefact(robot, network=NETWORK):
    """Return the folder of the network shipped for an arm and its effort kind, or None."""
    for card, content in _shipped_cards(CARD):
        if network_of(content) == network and not not_of(content, robot) and _whole(content):
            return card.parent
    return None


def _whole(content):
    """Tell whether a card's network reads all joints and answers all parameters (E1.5)."""
    design = content['recipe'].get('design')
    return design is None or (len(design['joints']) == len(content['joints'])
                              and len(design['parameters']) == len(MESSAGE_ORDER))


def shipped_difference(model):
    """Return the folder of the torque difference shipped for a TorqueModel, or None."""
    digest = model_digest(model)
    return next((card.parent for card, content in _shipped_cards(difference_artefact.CARD)
                 if content.get('model') == digest), None)


def shipped_intervals(model, method):
    """Return the folder of intervals shipped for this TorqueModel and Method, or None."""
    if with_network(method.name):
        return None
    kind, origin = kind_of(method.name), origin_of(model, method)
    return next((card.parent for card, content in _shipped_cards(CARD)
                 if network_of(content) == kind and content.get('origin') == origin), None)


def _shipped_cards(name):
    """Yield (path, content) of the shipped artefacts' cards of a file name."""
    for card in sorted((share_folder() / 'config' / 'learned').glob(f'*/{name}')):
        try:
            yield card, json.loads(card.read_text(encoding='utf-8'))
        except ValueError as error:
            raise ConfigurationError(card, f'is not JSON ({error})',
                                     todo='install the package again') from None


def build_method(model, uncertainties, name, learned=None, intervals=None):
    """
    Return the Method of a name for a TorqueModel.

    learned: artefact folder, short name of a shipped one, or None for that of the arm. Without
    any, a method with a network becomes `bayes` and the method's name says so, while one on a
    learned torque difference fails. intervals: folder of its calibration where it has no network,
    short name of a shipped one, or None for deviations as the method states them.
    """
    return with_intervals(model, _stating(model, uncertainties, name, learned), intervals)


def with_intervals(model, method, intervals):
    """Return a Method with intervals: as of build_method."""
    if not intervals:
        return method
    if with_network(method.name):
        raise ConfigurationError('intervals', 'go with methods without a network, not with '
                                 f'{method.name}, which brings its own', intervals)
    folder = find_shared(intervals, 'learned')
    return Calibrated(method, read_intervals(folder, model.robot, method.name), model)


def _stating(model, uncertainties, name, learned):
    """Return the Method that states deviations as it has them."""
    if name not in METHODS:
        raise ConfigurationError('method', 'is not known', name, ', '.join(METHODS))
    way = METHODS[name]
    if way.learned is None:
        if learned:
            raise ConfigurationError('learned', f'goes with methods that learn, not with {name}',
                                     learned,
                                     ', '.join(k for k, w in METHODS.items() if w.learned))
        return way.build(model, uncertainties, None)
    folder = find_shared(learned, 'learned') if learned else _shipped(model, name, way.learned)
    if folder is None:
        return METHODS[WITHOUT_ARTEFACT].build(model, uncertainties, None)
    return way.build(model, uncertainties, folder)


def _shipped(model, name, learned):
    """Return the folder of what is shipped for a method, or None where it can go without."""
    if learned != DIFFERENCE:
        return shipped_artefact(model.robot, learned)
    folder = shipped_difference(model)
    if folder is None:
        raise ConfigurationError(f'method {name}', 'needs a learned torque difference of this '
                                 'model, and none is shipped',
                                 todo=difference_artefact.AGAIN + ' and give it as learned')
    return folder


def build_pipeline(model_path, method=DEFAULT, learned=None, robot_path=None, tool_path=None,
                   intervals=None):
    """
    Return the Pipeline of a model file; raises ConfigurationError.

    robot_path: robot file the model must belong to, by joints, where they lie and effort kind, or
    None; tool_path: load file of a known tool, or None: the estimate is what is held beside it;
    learned, intervals: as of build_method; without intervals those shipped for this very model.
    """
    model_file = find_shared(model_path, 'models')
    # Before it is read: should it be replaced meanwhile, a checkpoint is refused, not misread.
    digest = hashlib.sha256(model_file.read_bytes()).hexdigest()
    model = (read_model(model_file) if robot_path is None else
             model_of_robot(model_file, load_robot(find_shared(robot_path, 'robots'))))
    follower, tool = ModelFollower(model), read_tool(tool_path) if tool_path else None
    if tool:
        follower = ToolFollower(follower, tool)
    method = build_method(model, follower.uncertainties, method, learned or None)
    method = with_intervals(model, method, intervals or shipped_intervals(model, method))
    return Pipeline(model, follower, method, determined_std(model.robot), model_file=model_file,
                    digest=digest, tool=tool)
