"""`hand_load train`: make a learned artefact from a torque model."""

from pathlib import Path

EXAMPLE = 'hand_load train --model model.yaml --out learned/my_arm'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='identified torque model to draw arms around')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder of the artefact; an unfinished training in it is resumed')
    parser.add_argument('--device', choices=('auto', 'cpu', 'cuda'), default='auto',
                        help='where to train (auto: cuda where there is one)')
    parser.add_argument('--sequences', type=int, default=None, metavar='N',
                        help='training sequences of 10 s (default 6400)')
    parser.add_argument('--passes', type=int, default=None, metavar='N',
                        help='passes over them (default 9)')


def run(args):
    """Train; progress goes to standard output."""
    from dataclasses import replace

    from ..errors import ConfigurationError
    from ..learning.training import Recipe, train
    recipe = Recipe()
    for name in ('sequences', 'passes'):
        value = getattr(args, name)
        if value is not None and value < 1:
            raise ConfigurationError(f'--{name}', 'is not usable', value, 'at least 1')
        if value is not None:
            recipe = replace(recipe, **{name: value})
    scores = train(args.model, args.out, recipe, args.device,
                   write=lambda text: print(text, flush=True))
    print(f'artefact in {Path(args.out)}')
    for name, values in scores.items():
        print(f'  {name}: ' + ', '.join(f'{k} {v}' for k, v in values.items()))
    return 0
