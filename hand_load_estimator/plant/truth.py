"""Draw what the plant really is: links, rotors and drives that differ from the robot file."""

from dataclasses import dataclass, field

import numpy as np

from ..load import pseudo_inertia
from .difficulty import by_size
from .friction import draw_friction, FrictionFigures


@dataclass
class Truth:
    """
    The true arm. Hidden effects change it before the plant is built, never afterwards.

    links: n pseudo-inertias (4, 4) in the joint frames; rotor (n,) [kg m^2]; gravity (3,);
    friction; noise (n,) [Nm]; constants (n,) [Nm/A or 1]; effort_gain, effort_gain_slope [1/K],
    effort_bend [1/Nm] (what is reported is tanh(bend x torque) / bend), effort_offset [Nm],
    effort_delay [s] (n,); joint_torques, forces: what acts beside these; held:
    what hangs on the hand for a time beside the plant's load.
    """

    links: list
    rotor: np.ndarray
    gravity: np.ndarray
    friction: FrictionFigures
    noise: np.ndarray
    constants: np.ndarray
    effort_gain: np.ndarray
    effort_gain_slope: np.ndarray
    effort_bend: np.ndarray
    effort_offset: np.ndarray
    effort_delay: np.ndarray
    joint_torques: list = field(default_factory=list)
    forces: list = field(default_factory=list)
    held: list = field(default_factory=list)


def draw_truth(robot, difficulty, rng):
    """Return the Truth of one plant."""
    file, n = robot.file, robot.n
    spread = difficulty.rotor_spread
    rotor = by_size(difficulty.rotor_inertia, file.max_torque)
    doubt = np.clip(rng.standard_normal(n), -2.0, 2.0) * file.effort.torque_constants_std
    return Truth(
        links=[_wrong(robot.nominal_links[10 * j:10 * j + 10], difficulty.link_error, rng)
               for j in range(n)],
        rotor=rotor * rng.uniform(1.0 - spread, 1.0 + spread, n),
        gravity=np.array(file.gravity), friction=draw_friction(robot, difficulty, rng),
        noise=by_size(difficulty.torque_noise, file.max_torque),
        constants=file.effort.torque_constants * (1.0 + doubt),
        effort_gain=np.ones(n), effort_gain_slope=np.zeros(n), effort_bend=np.zeros(n),
        effort_offset=np.zeros(n), effort_delay=np.zeros(n))


def _wrong(products, error, rng):
    """
    Return a pseudo-inertia whose mass, centre of mass and inertia are off by up to `error`.

    A congruence of the second moments about the centre of mass keeps the body one that can
    exist: the result is positive semidefinite whenever the nominal link is.
    """
    pseudo = pseudo_inertia(products)
    mass = pseudo[3, 3]
    com = pseudo[:3, 3] / mass if mass > 0.0 else np.zeros(3)
    second = pseudo[:3, :3] - mass * np.outer(com, com)
    mass_factor, *factors = 1.0 + error * rng.uniform(-1.0, 1.0, 4)
    direction = rng.standard_normal(3)
    away = error * rng.uniform() * np.linalg.norm(com) * direction / np.linalg.norm(direction)
    stretch = np.sqrt(factors)
    return assemble(mass * mass_factor, com + away, second * np.outer(stretch, stretch))


def assemble(mass, com, second):
    """Return the pseudo-inertia of a mass, its centre and second moments (3, 3) about it."""
    out = np.empty((4, 4))
    out[:3, :3] = second + mass * np.outer(com, com)
    out[:3, 3] = out[3, :3] = mass * com
    out[3, 3] = mass
    return out
