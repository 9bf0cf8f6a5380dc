"""
mujoco.sysid as a rival: the load as a body whose pseudo-inertia its optimiser fits.

The arm is a chain of bodies that weigh nothing, so that inverse dynamics of the MuJoCo model is
the load's torque alone; that is exact, because torque is linear in inertial parameters. Used of
mujoco.sysid: ParameterDict, body_inertia_param with InertiaType.Pseudo (always a possible body),
ModelSequences, build_residual_fn, optimize and calculate_intervals. Put in the place its
interface has for it: custom_rollout by mj_inverse along the measured motion, because rolling
3 to 13 s of measured torques forward through Coulomb friction ends far from the recording; and
modify_residual, which weighs joints by their model error.
"""

from contextlib import redirect_stdout
import io

from absl import logging
import mujoco
from mujoco.sysid import (body_inertia_param, build_residual_fn, calculate_intervals,
                          create_initial_state, InertiaType, ModelSequences, optimize,
                          ParameterDict, SystemTrajectory, TimeSeries)
from mujoco.sysid._src.model_modifier import pi_from_theta
from mujoco.sysid._src.timeseries import SignalType
import numpy as np

from ..load import LoadParameters
from ..plant.arm import chain_spec, LOAD

_ITERATIONS = 50
# Bounds of the pseudo-inertia beside the rated load's.
_MASS, _STRETCH, _SHEAR, _PLACE = (1e-4, 2.0), (1e-3, 1e3), (-0.5, 0.5), (-0.5, 0.5)


def identify_load(robot, run):
    """Return mean (10,) and std (10,) in message order of the load in a LoadedRun."""
    logging.set_verbosity(logging.ERROR)
    spec = _spec(robot)
    model = spec.compile()
    observed = {'torque': (SignalType.CustomObs, np.arange(robot.n))}
    sequences = ModelSequences(
        'arm', spec, 'run', create_initial_state(model, run.q[0], run.v[0]),
        TimeSeries(run.stamp, np.zeros((len(run.stamp), 0)), {}),
        TimeSeries(run.stamp, run.torque, observed), allow_missing_sensors=True)
    parameters = ParameterDict()
    parameters.add(body_inertia_param(
        spec, model, LOAD, InertiaType.Pseudo, mass_bound_mult=np.array(_MASS),
        stretch_bound_mult=np.array(_STRETCH), shear_bound_off=np.array(_SHEAR),
        ipos_bound_off=np.array(_PLACE), modifier=_apply))
    residual = build_residual_fn(
        models_sequences=[sequences], resample_true=False, n_threads=1,
        custom_rollout=_rollout(run, observed), modify_residual=_weighed(run))
    # Its optimiser tells every step on stdout.
    with redirect_stdout(io.StringIO()):
        found, result = optimize(parameters, residual, verbose=False, max_iters=_ITERATIONS)
    covariance, _ = calculate_intervals(residual(result.x, found)[0], np.asarray(result.jac))
    return _message(np.asarray(result.x).ravel(), covariance)


def _spec(robot):
    """Return the MjSpec of an arm without mass that holds the rated load."""
    n, load = robot.n, robot.rated_load
    spec = chain_spec(robot, np.zeros((n, 4, 4)), np.zeros(n), robot.model.gravity.linear)
    # A rated load given as a point has no pseudo-inertia with a logarithm.
    _write(spec, load.mass, load.com, load.inertia + 1e-3 * load.mass * np.eye(3))
    return spec


def _write(spec, mass, com, inertia):
    """Give the load's body a mass, centre of mass (3,) and inertia (3, 3) about it."""
    body = spec.body(LOAD)
    body.mass, body.ipos = mass, com
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    body.inertia, body.iquat = moments, quaternion


def _body_of(theta):
    """Return mass, com (3,) and inertia (3, 3) about it of mujoco.sysid's ten parameters."""
    pi = pi_from_theta(np.asarray(theta, dtype=float))
    mass, com, about_origin = pi[0], pi[1:4] / pi[0], pi[4:].reshape(3, 3)
    return mass, com, about_origin - mass * (com @ com * np.eye(3) - np.outer(com, com))


def _apply(spec, parameter):
    """
    Write the parameters into the spec, in place of mujoco.sysid's own modifier.

    That one writes `fullinertia`, which MuJoCo 4.0 compiles to an inertia of zero for a body
    whose inertial frame was given as a quaternion.
    """
    _write(spec, *_body_of(parameter.value))


def _inverse(model, run):
    """Return the torque (N, n) of a model along the measured motion."""
    data, out = mujoco.MjData(model), np.empty_like(run.torque)
    for k in range(len(out)):
        data.qpos[:], data.qvel[:], data.qacc[:] = run.q[k], run.v[k], run.a[k]
        mujoco.mj_inverse(model, data)
        out[k] = data.qfrc_inverse
    return out


def _rollout(run, observed):
    """Return a custom_rollout for mujoco.sysid: inverse dynamics instead of integration."""
    def rollout(models, control_signal, initial_states, **_):
        """Return a SystemTrajectory for each of several models, as mujoco.sysid calls it."""
        state = np.column_stack([run.stamp, run.q, run.v])
        return [SystemTrajectory(model, control, TimeSeries(run.stamp, _inverse(model, run),
                                                            observed),
                                 start, TimeSeries(run.stamp, state))
                for model, control, start in zip(models, control_signal, initial_states)]
    return rollout


def _weighed(run):
    """Return a modify_residual for mujoco.sysid: torque differences over the model's error."""
    def modify(params, predicted, measured, model, return_all, state=None):
        """Return weighed residuals and both TimeSeries, as mujoco.sysid calls it."""
        return ((predicted.data - measured.data) * run.weight).ravel(), predicted, measured
    return modify


def _message(theta, covariance):
    """Return mean and std in message order, the latter by linearisation."""
    def message(vector):
        """Return the load of mujoco.sysid's parameters (10,) in message order."""
        return LoadParameters(*_body_of(vector)).to_message()

    step, mean = 1e-6, message(theta)
    slope = np.array([(message(theta + step * e) - message(theta - step * e)) / (2.0 * step)
                      for e in np.eye(len(theta))]).T
    return mean, np.sqrt(np.maximum(np.diag(slope @ covariance @ slope.T), 0.0))
