"""What the columns of a torque model read, along whole motions."""

from dataclasses import dataclass
from functools import cached_property
from weakref import proxy

import numpy as np

from ..effects import EffectInput
from ..motion import Motion
from ..robot import Robot
from .columns import warmth_of
from .shown_along import followed_together, ShownPart
from .shown_friction import course_of
from .shown_links import shown_links_and_way
from .start_doubt import rests_along, start_doubt_along


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """A Motion of a Robot, and what of it is the same over whatever travels friction turns."""

    robot: Robot
    motion: Motion

    @cached_property
    def part(self):
        """Its ShownPart."""
        motion = self.motion
        return ShownPart(course_of(motion), warmth_of(self.robot, motion.temperature), motion.dt,
                         np.zeros(len(motion.dt)) if motion.course is None else motion.messages)

    @cached_property
    def rests(self):
        """The rests_along of it."""
        return rests_along(self.motion.q, self.motion.v, self.motion.dt)

    @cached_property
    def links(self):
        """The shown_links_and_way of it."""
        return shown_links_and_way(self.robot, self.motion)

    def input(self, shown):
        """Return (EffectInput, doubt (N, n)) of a ShownAlong this one motion."""
        motion, part = self.motion, self.part
        x = EffectInput(motion.q, motion.v, motion.a, part.warmth, shown.z, shown=shown,
                        jerk=motion.jerk, at_once=part.at_once)
        return x, start_doubt_along(part.moved, self.rests, part.dt, shown.own[0])


def known_motion(robot, motion):
    """Return the KnownMotion of a Motion, which keeps it: it is asked for again and again."""
    if robot not in motion.known:
        # What knows a motion does not keep it alive.
        motion.known[robot] = KnownMotion(robot, proxy(motion))
    return motion.known[robot]


def motion_input(robot, motion, distance, power=None):
    """
    Return (EffectInput, doubt (N, n)) along a Motion.

    distance (n,) [rad], power (n,): of presliding.Turning, infinite without any.
    """
    own = distance, np.full(robot.n, np.inf) if power is None else power
    return next(motion_inputs(robot, [motion], [own]))[0]


def motion_inputs(robot, motions, ways):
    """
    Yield the [(EffectInput, doubt)] of Motions, with friction turning in each of the ways.

    ways: (distance, power) pairs as of motion_input, which are followed side by side.
    """
    known = [known_motion(robot, motion) for motion in motions]
    followed = followed_together([motion.part for motion in known], ways)
    for shown in followed:
        yield [motion.input(own) for motion, own in zip(known, shown)]
