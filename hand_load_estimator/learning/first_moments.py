"""
Mass, first moment and inertia: what a direct network learns in place of mass, centre and inertia.

Torque is linear in the first moment h = m c, while the centre c = h / m asks a network to divide.
Its error grows without limit as a load becomes light, and drowns what heavy loads could teach.
Order as in a message, with h in the places of c; (..., 10) throughout.
"""

import torch

from .regression_layer import message_moments

# What a card says of networks that do: others' numbers mean something else.
LEARNS = 'mass, first moment, inertia'
PLACES = slice(1, 4)
# Widths of the labels: [kg], [kg m], [kg m^2]; no answer needs to be surer than that.
LABEL_STD = (1e-3,) * 4 + (2e-4,) * 6


def message_prior(prior):
    """Return mean and std (10,) in message order of a LoadPrior."""
    mean, variance = message_moments(torch.tensor(prior.mean),
                                     torch.diag(torch.tensor(prior.std) ** 2))
    return mean, torch.sqrt(variance)


def moments_prior(prior):
    """Return mean and std (10,) of mass, first moment and inertia of a LoadPrior."""
    mean, std = message_prior(prior)
    m, c, m_var, c_var = mean[0], mean[PLACES], std[0] ** 2, std[PLACES] ** 2
    moments, spread = mean.clone(), std.clone()
    moments[PLACES] = m * c
    spread[PLACES] = torch.sqrt(m ** 2 * c_var + c ** 2 * m_var + m_var * c_var)
    return moments, spread


def moments_of(load):
    """Return mass, first moment and inertia of loads in message order."""
    return torch.cat([load[..., :1], load[..., :1] * load[..., PLACES], load[..., 4:]], dim=-1)


def message_of(mean, std, prior_mean, prior_std):
    """
    Return mean and std in message order of independent normals of m, h and inertia.

    prior_mean, prior_std (10,): of the message. The centre is its posterior under h = m c, to
    first order in what is not known of m: a load too light to tell has the prior's. What is
    answered counts as data beside that prior, though a network has learnt one: early answers are
    drawn to it and stated narrower (0.87 of it before any data); calibration mends the width.
    """
    m, h = mean[..., :1].clamp(min=0.0), mean[..., PLACES]
    c0, c0_var = prior_mean[PLACES], prior_std[PLACES] ** 2
    # Thinned networks may agree to the last bit.
    noise = (std[..., PLACES] ** 2 + (c0 ** 2 + c0_var) * std[..., :1] ** 2).clamp(min=1e-12)
    precision = 1.0 / c0_var + m ** 2 / noise
    centre = (c0 / c0_var + m * h / noise) / precision
    return (torch.cat([mean[..., :1], centre, mean[..., 4:]], dim=-1),
            torch.cat([std[..., :1], precision ** -0.5, std[..., 4:]], dim=-1))
