"""
How hard the plant is: the figures every draw of a plant is made from.

Figures per joint are tabled over the drive's peak torque, so that they fit an arm of any size:
between and beyond the tabled sizes they follow straight lines in log-log scale. The table is a
UR10e's three joint sizes. config/plant.yaml shows the same figures to readers.
"""

from dataclasses import dataclass

import numpy as np

SIZES = (54.0, 150.0, 330.0)  # [Nm] peak torque of the tabled joints


@dataclass(frozen=True)
class Difficulty:
    """
    The figures of section 6 of the design, with units; a pair is (lowest, highest) of a draw.

    Friction follows Bittencourt and Axelsson (2014), equation and figures for joints of
    industrial robots: Coulomb and static friction, a Stribeck velocity that rises and a viscous
    friction that falls with temperature.
    """

    # tabled over SIZES
    torque_noise: tuple = (0.35, 0.9, 1.2)        # [Nm] white, per published sample
    coulomb: tuple = (2.1, 5.0, 9.0)              # [Nm] at 25 degC
    viscous: tuple = (1.6, 5.0, 12.0)             # [Nm s/rad] at 25 degC
    rotor_inertia: tuple = (0.5, 1.5, 3.5)        # [kg m^2] at the joint
    heat_capacity: tuple = (80.0, 220.0, 500.0)   # [J/K] of the gear and its oil
    cooling: tuple = (0.2, 0.55, 1.2)             # [W/K] of the joint to the room
    drive_loss: tuple = (15.0, 40.0, 90.0)        # [W] at peak torque, grows with its square

    # drawn per joint
    link_error: float = 0.08                      # [-] of mass, centre of mass, inertia
    friction_spread: float = 0.2                  # [-] of Coulomb and viscous friction
    rotor_spread: float = 0.2                     # [-]
    asymmetry: float = 0.05                       # [-] of Coulomb friction, either direction
    stribeck: tuple = (0.10, 0.25)                # [-] static friction above Coulomb friction
    stribeck_velocity: tuple = (0.03, 0.08)       # [rad/s] at 25 degC
    stribeck_velocity_rise: tuple = (0.0, 0.001)  # [rad/s/K]
    stribeck_exponent: tuple = (1.0, 1.5)         # [-]
    viscous_fall: tuple = (0.012, 0.018)          # [1/K] at 25 degC
    viscous_fall_range: tuple = (28.0, 36.0)      # [K] over which the falling part goes as 1/e
    coulomb_fall: tuple = (0.0, 0.002)            # [1/K]
    presliding: tuple = (1.0e-3, 2.0e-3)          # [rad] travel after a reversal until sliding

    # thermal, beside the tabled figures
    sensor_share: float = 0.6                     # [-] the sensor node's capacity per the gear's
    exchange: float = 2.0                         # [-] gear to sensor node, per cooling
    drive_loss_in_gear: float = 0.3               # [-] share of the drive loss that heats the gear
    temperature_spread: float = 1.0               # [K] of the joints at the start

    # sensors
    position_quantum: float = 1e-5                # [rad]
    position_noise: float = 5e-6                  # [rad]
    velocity_noise: float = 2e-3                  # [rad/s]
    torque_quantum: float = 0.1                   # [-] of the torque noise
    temperature_noise: float = 0.07               # [K]
    temperature_quantum: float = 0.1              # [K]


DEFAULT = Difficulty()


def by_size(figures, max_torque):
    """Return the tabled figures (n,) for joints of peak torque max_torque (n,) [Nm]."""
    if not np.any(figures):
        return np.zeros(len(max_torque))
    x, y, at = np.log(SIZES), np.log(figures), np.log(max_torque)
    piece = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    slope = (y[piece + 1] - y[piece]) / (x[piece + 1] - x[piece])
    return np.exp(y[piece] + slope * (at - x[piece]))
