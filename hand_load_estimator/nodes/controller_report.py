"""What /diagnostics says of the controller: its motion, the load it counts on, collisions."""

from .diagnostics import ERROR, OK, WARN
from .model_cautions import cautions


def report_motion(supervisor, listened, clocked):
    """
    Return (level, message, values) of a Supervisor's motion.

    listened: whether somebody takes its trajectories; clocked: whether there is a time.
    """
    move = supervisor.move
    values = {'phase': supervisor.phase, **supervisor.counts}
    if move is not None:
        values.update({'planned for': f'{move.basis} load', 'move time [s]': move.duration,
                       'acceleration time [s]': move.profile.acceleration_time,
                       'deceleration time [s]': move.profile.deceleration_time})
    return (*_motion(supervisor, move, listened, clocked), values)


def _motion(supervisor, move, listened, clocked):
    """Return level and message, the worst first."""
    if supervisor.phase == 'stopped':
        return ERROR, f'{supervisor.stop_reason}; call ~/reset, then ~/start'
    if not clocked:
        return WARN, 'use_sim_time is set and no /clock arrives: nothing moves'
    if not listened:
        return WARN, 'nobody takes joint_trajectory_controller/joint_trajectory'
    if move is not None and not move.feasible:
        return WARN, move.reason
    if supervisor.tries:
        return WARN, f'the arm does not follow; try {supervisor.tries + 1}'
    if supervisor.phase == 'waiting':
        return OK, 'waiting for ~/start'
    return OK, supervisor.phase


def report_load(policy):
    """Return (level, message, values) of a LoadPolicy."""
    values = {'caution': policy.caution, 'basis': policy.belief.source,
              'mass [kg]': float(policy.belief.mean[0])}
    if policy.trusted:
        return OK, 'the estimate is used', values
    return WARN, f'the rated load is used: {policy.reason}', values


def report_torque_model(model, simulated):
    """Return (level, message, values) of the TorqueModel that moves are planned with."""
    told = '; '.join(cautions(model, simulated))
    values = {'recordings': ', '.join(model.recording_names) or 'none'}
    return (WARN, told, values) if told else (OK, 'the model in use', values)


def report_collision(supervisor):
    """Return (level, message, values) of a Supervisor's watch for collisions."""
    values = {}
    if supervisor.in_force is not None:
        values = {f'threshold {joint} [Nm]': float(value) for joint, value in
                  zip(supervisor.robot.joints, supervisor.in_force.threshold)}
    if supervisor.detector.collided:
        return ERROR, supervisor.stop_reason, values
    if supervisor.policy.blind:
        return WARN, f'{supervisor.policy.blind}; moves keep the rated load\'s limits', values
    return OK, 'no collision', values
