"""`hand_load train`: make a learned artefact from a torque model."""

from pathlib import Path

from ..errors import ConfigurationError
from ..learning.direct_design import design_for, NETWORKS

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
    parser.add_argument('--sequences', type=int, default=None, metavar='N',
                        help='training sequences of 10 s (default 6400; 1024 for the others)')
    parser.add_argument('--passes', type=int, default=None, metavar='N',
                        help='passes over them (default 9; 60 for the others)')


def _names(text):
    return tuple(name.strip() for name in text.split(',') if name.strip())


def run(args):
    """Train; progress goes to standard output."""
    for name in ('sequences', 'passes'):
        value = getattr(args, name)
        if value is not None and value < 1:
            raise ConfigurationError(f'--{name}', 'is not usable', value, 'at least 1')
    scores = _train(args)
    print(f'artefact in {Path(args.out)}')
    for name, values in scores.items():
        print(f'  {name}: ' + ', '.join(f'{k} {v}' for k, v in values.items()))
    return 0


def _train(args):
    chosen = {name: value for name in ('sequences', 'passes')
              if (value := getattr(args, name)) is not None}

    def write(text):
        print(text, flush=True)

    if args.network == 'lstm':
        from ..learning.training import Recipe, train
        for name in ('joints', 'parameters'):
            if getattr(args, name) is not None:
                raise ConfigurationError(f'--{name}', 'does not go with --network lstm',
                                         allowed=', '.join(NETWORKS))
        return train(args.model, args.out, Recipe(**chosen), args.device, write)
    from ..learning.direct_training import DirectRecipe, train_direct
    from ..model_file import read_model
    design = design_for(read_model(args.model).robot, args.network, args.joints, args.parameters)
    return train_direct(args.model, args.out, DirectRecipe(design, **chosen), args.device, write)
