"""`hand_load train`: make a learned artefact from a torque model, or fit one to a better model."""

from dataclasses import replace
from pathlib import Path

from ..errors import ConfigurationError
from ..files.shared_files import find_shared
from ..learning.artefact import artefact_folder
from ..learning.direct_design import design_for, NETWORKS, SIZES

EXAMPLE = """
hand_load train --model model.yaml --out learned/my_arm
hand_load train --model model.yaml --network gru --parameters m,x,y,z --out learned/my_arm_gru
"""


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='identified torque model to draw arms around')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder of the artefact; an unfinished training in it is resumed')
    parser.add_argument('--start-from', default=None, metavar='DIR',
                        help='fine-tune: artefact of the same arm, or the name of a shipped one, '
                             'whose weights are the first ones (lstm only)')
    parser.add_argument('--device', choices=('auto', 'cpu', 'cuda'), default='auto',
                        help='where to train (auto: cuda where there is one)')
    parser.add_argument('--network', choices=('lstm', *NETWORKS), default='lstm',
                        help='lstm: in front of the regression, the default method; the others '
                             'go straight to the load: ' + '; '.join(
                                 f'{name}: {text}' for name, text in NETWORKS.items()))
    parser.add_argument('--joints', type=_names, default=None, metavar='A,B,...',
                        help='joints the network reads (default all; not for lstm)')
    parser.add_argument('--parameters', type=_names, default=None, metavar='A,B,...',
                        help='parameters it answers, of m, x, y, z, ixx, ixy, ixz, iyy, iyz, izz '
                             '(default all; not for lstm)')
    parser.add_argument('--hidden', type=int, default=None, metavar='N',
                        help='units of a hidden layer (default 96; not for lstm)')
    parser.add_argument('--layers', type=int, default=None, metavar='N',
                        help='hidden layers: recurrent ones, or those behind the window (default '
                             '1; not for lstm)')
    parser.add_argument('--window', type=int, default=None, metavar='N',
                        help='samples of 20 ms that feedforward reads at once (default 25)')
    parser.add_argument('--divergence', choices=('kl', 'jensen_shannon'), default=None,
                        help='what training minimises between the true load and the answer\'s '
                             'mean and variance (default kl; not for dropout, which is trained '
                             'without a variance)')
    parser.add_argument('--sequences', type=int, default=None, metavar='N',
                        help='training sequences of 10 s (default 6400, to fine-tune 1216; 2048 '
                             'for the others)')
    parser.add_argument('--passes', type=int, default=None, metavar='N',
                        help='passes over them (default 9, to fine-tune 3; 0 calibrates anew and '
                             'nothing else: the weights of --start-from or, without, the '
                             'regression alone, whose network then says nothing; 120 for the '
                             'others, at least 1)')


def _names(text):
    return tuple(name.strip() for name in text.split(',') if name.strip())


def run(args):
    """Train; progress goes to standard output."""
    for name, least in (('sequences', 1), ('passes', 0 if args.network == 'lstm' else 1)):
        value = getattr(args, name)
        if value is not None and value < least:
            raise ConfigurationError(f'--{name}', 'is not usable', value, f'at least {least}')
    scores = _train(args)
    print(f'artefact in {Path(args.out)}')
    for name, values in scores.items():
        print(f'  {name}: ' + ', '.join(f'{k} {v}' for k, v in values.items()))
    return 0


def _train(args):
    chosen = {name: value for name in ('sequences', 'passes', 'divergence')
              if (value := getattr(args, name)) is not None}

    def write(text):
        print(text, flush=True)

    model = find_shared(args.model, 'models')
    start = args.start_from and find_shared(args.start_from, 'learned')
    artefact_folder(args.out, args.network, (model, start))
    if args.network == 'lstm':
        from ..learning.training import FINE_TUNING, Recipe, train
        _refuse(args, ('joints', 'parameters', *SIZES), ', '.join(NETWORKS))
        recipe = replace(FINE_TUNING if start else Recipe(), **chosen)
        return train(model, args.out, recipe, args.device, write, start)
    from ..learning.direct_training import DirectRecipe, train_direct
    from ..torque.model_file import read_model
    _refuse(args, ('start_from',), 'lstm')
    if args.network != 'feedforward':
        _refuse(args, ('window',), 'feedforward')
    if args.network == 'dropout':
        _refuse(args, ('divergence',), 'every other one')
    sizes = {name: getattr(args, name) for name in SIZES if getattr(args, name) is not None}
    design = design_for(read_model(model).robot, args.network, args.joints, args.parameters,
                        **sizes)
    return train_direct(model, args.out, DirectRecipe(design, **chosen), args.device, write)


def _refuse(args, names, allowed):
    """Refuse options that do not go with the network that is asked for."""
    for name in names:
        if getattr(args, name) is not None:
            raise ConfigurationError(f'--{name.replace("_", "-")}',
                                     f'does not go with --network {args.network}',
                                     allowed=allowed)
