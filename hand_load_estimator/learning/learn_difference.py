"""Learn a function of the no-load torque difference from recordings and write it (E2.1, E2.6)."""

from dataclasses import replace

import numpy as np
import torch

from ..errors import ConfigurationError
from ..estimators.inducing_points import InducingPoints
from ..estimators.network_draws import NetworkDraws
from .bayesian_network import learn_bayesian_network
from .difference_artefact import PREDICTORS, write_difference
from .difference_data import difference_data
from .difference_inputs import DEFAULT_INPUTS
from .distilled_network import distil
from .left_out import left_out
from .neural_process import learn_neural_process
from .torque_gp import learn_gp, learn_kernel, process_posterior

SEED = 1


def learn_difference(folder, model, evidence, function='gp', names=DEFAULT_INPUTS,
                     write=lambda text: None):
    """
    Learn from a list of Evidence what a TorqueModel leaves, write the artefact into `folder`.

    function: a name of PREDICTORS; names: inputs. Return the LeftOut.
    """
    if function not in PREDICTORS:
        raise ConfigurationError('--function', 'is not known', function, ', '.join(PREDICTORS))
    torch.set_num_threads(1)
    data = difference_data(model, evidence, names)
    tensors, result = _learned(data, function, write)
    write_difference(
        folder, model, function, names,
        {**tensors, 'scale': data.scale, 'gain': result.gain, 'share': result.share,
         'left_out_variance': result.variance},
        {'recordings': [e.name for e in evidence],
         'known_load': any(e.load.mass > 0.0 for e in evidence), 'seed': SEED,
         'samples': len(data.dt),
         'gain': [round(float(v), 4) for v in result.gain],
         'left_out_density_share': [round(float(v), 4) for v in result.share]})
    return result


def _learned(data, function, write):
    """Return (tensors of the predictor, LeftOut)."""
    if function == 'neural_process':
        return learn_neural_process(data, SEED, write)
    if function == 'gp':
        return learn_gp(data, SEED, write)
    return _follow({'distilled': distil, 'bayesian_network': learn_bayesian_network}[function],
                   data, write)


def _follow(pupil, data, write):
    """
    Return (tensors, LeftOut) of networks that learn to answer as the process does.

    Where a recording is left out, neither they nor the process they follow have seen it, only
    the process's kernel has: a pupil may be worse than its teacher.
    """
    kernel = learn_kernel(data, SEED, write)

    def learn(rows, write=lambda text: None):
        teacher = InducingPoints(process_posterior(data, kernel, rows))
        return pupil(replace(data, inputs=data.inputs[rows]), teacher, SEED, write)
    everything = np.ones(len(data.dt), dtype=bool)
    return learn(everything, write), left_out(data, lambda rows: NetworkDraws(learn(rows)).at)
