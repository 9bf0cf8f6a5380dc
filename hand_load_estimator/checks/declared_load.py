"""Does a recording show another load than the one that is declared to be in the hand?"""

from dataclasses import replace

from .finding import DOUBT, WRONG
from .recording_check import check_recording

_PLACED = ('mass', 'com', 'inertia')


def another_load(robot, recording, load):
    """
    Return in words that a Recording surely shows another load than LoadParameters, else ''.

    As `hand_load check` judges it, for identification takes what is declared for true: links
    would carry what nobody told of, and every estimate would be off by it.
    """
    check = check_recording(replace(recording, load=load, load_known=_PLACED), robot)
    told = [f for f in check.findings if f.item == 'load' and f.verdict in (DOUBT, WRONG)]
    if not told:
        return ''
    return (f'{told[0].text}; identification takes what is stated for true, and '
            f'every estimate will be off by the difference; {told[0].todo}')
