"""What the columns of a torque model read, along whole motions."""

from dataclasses import dataclass
from functools import cached_property
from weakref import proxy

import numpy as np

from ..effects import EffectInput
from ..effects.own_travel import BOTH
from ..motion import Motion
from ..robot import Robot
from .columns import warmth_of
from .shown_along import followed_together, SeenCourse, ShownPart
from .shown_friction import course_of
from .shown_links import shown_links_and_way
from .start_doubt import rests_along, start_doubt_along


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """A Motion of a Robot, and what of it is the same over whatever travels friction turns."""

    robot: Robot
    motion: Motion

    @cached_property
    def seen(self):
        """Its SeenCourse."""
        motion = self.motion
        return SeenCourse(course_of(motion), motion.dt, np.zeros(len(motion.dt))
                          if motion.course is None else motion.messages)

    @cached_property
    def warmth(self):
        """Temperatures less the reference (N, n) [K], 0 where unknown."""
        return warmth_of(self.robot, self.motion.temperature)

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
        motion, part = self.motion, shown.parts[0]
        x = EffectInput(motion.q, motion.v, motion.a, self.warmth, shown.z, shown=shown,
                        jerk=motion.jerk, at_once=self.seen.at_once)
        return x, start_doubt_along(part.moved, self.rests, motion.dt, shown.own[0])


def known_motion(robot, motion):
    """Return the KnownMotion of a Motion, which keeps it: it is asked for again and again."""
    if robot not in motion.known:
        # What knows a motion does not keep it alive.
        motion.known[robot] = KnownMotion(robot, proxy(motion))
    return motion.known[robot]


def motion_input(robot, motion, distance, plastic=None, level=None):
    """
    Return (EffectInput, doubt (N, n)) along a Motion.

    distance (n,) [rad], plastic (n,): of presliding.Turning, all the way without any; level: the
    ContactLevel of the joints, None for none.
    """
    own = distance, np.full(robot.n, BOTH) if plastic is None else plastic
    return next(motion_inputs(robot, [motion], [own], level))[0]


def motion_inputs(robot, motions, ways, level):
    """
    Yield the [(EffectInput, doubt)] of Motions, with friction turning in each of the ways.

    ways: (distance, plastic) pairs as of motion_input, which are followed side by side; level: as
    of motion_input.
    """
    known = [known_motion(robot, motion) for motion in motions]
    followed = followed_together(
        [ShownPart(motion.seen, motion.warmth, level) for motion in known], ways)
    for shown in followed:
        yield [motion.input(own) for motion, own in zip(known, shown)]
