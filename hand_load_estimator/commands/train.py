"""`hand_load train`: make a learned artefact from a torque model, or fit one to a better model."""

from pathlib import Path

EXAMPLE = 'hand_load train --model model.yaml --out learned/my_arm'


def add_arguments(parser):
    """Declare the arguments."""
    parser.add_argument('--model', required=True, metavar='MODEL.yaml',
                        help='identified torque model to draw arms around')
    parser.add_argument('--out', required=True, metavar='DIR',
                        help='folder of the artefact; an unfinished training in it is resumed')
    parser.add_argument('--start-from', default=None, metavar='DIR',
                        help='fine-tune: artefact of the same arm, or the name of a shipped one, '
                             'whose weights are the first ones')
    parser.add_argument('--device', choices=('auto', 'cpu', 'cuda'), default='auto',
                        help='where to train (auto: cuda where there is one)')
    parser.add_argument('--sequences', type=int, default=None, metavar='N',
                        help='training sequences of 10 s (default 6400; to fine-tune 1216)')
    parser.add_argument('--passes', type=int, default=None, metavar='N',
                        help='passes over them (default 9; to fine-tune 3, where 0 keeps the '
                             'weights and calibrates anew)')


def run(args):
    """Train; progress goes to standard output."""
    from dataclasses import replace

    from ..errors import ConfigurationError
    from ..learning.training import FINE_TUNING, Recipe, train
    from ..shared_files import find_shared
    start = args.start_from and find_shared(args.start_from, 'learned')
    recipe = FINE_TUNING if start else Recipe()
    for name, least in (('sequences', 1), ('passes', 0 if start else 1)):
        value = getattr(args, name)
        if value is not None and value < least:
            raise ConfigurationError(f'--{name}', 'is not usable', value, f'at least {least}')
        if value is not None:
            recipe = replace(recipe, **{name: value})
    scores = train(args.model, args.out, recipe, args.device,
                   write=lambda text: print(text, flush=True), start_from=start)
    print(f'artefact in {Path(args.out)}')
    for name, values in scores.items():
        print(f'  {name}: ' + ', '.join(f'{k} {v}' for k, v in values.items()))
    return 0
