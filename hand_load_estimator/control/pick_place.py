"""The pick-and-place cycle as a sequence of steps."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Step:
    """
    One step of the cycle.

    phase: what is told outside; target: the waypoint to move to, or empty for a dwell of
    `dwell` [s]; grips: whether the hand grips or releases meanwhile.
    """

    phase: str
    target: str = ''
    dwell: float = 0.0
    grips: bool = False


def pick_and_place(cycles, dwell, home_dwell):
    """
    Yield the steps of `cycles` cycles (0: without end), from anywhere to home.

    dwell [s] at pick and place, home_dwell [s] at home.
    """
    yield Step('home', target='home')
    done = 0
    while cycles == 0 or done < cycles:
        yield Step('home', dwell=home_dwell)
        yield Step('to_pick', target='pick')
        yield Step('at_pick', dwell=dwell, grips=True)
        yield Step('carrying', target='place')
        yield Step('at_place', dwell=dwell, grips=True)
        yield Step('returning', target='home')
        done += 1
