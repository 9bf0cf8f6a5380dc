"""What /diagnostics says of the torque model: whether it has aged, which file, from what."""

from datetime import datetime

import numpy as np

from ..estimators.residual_watch import EARLIER
from .diagnostics import OK, WARN
from .model_cautions import cautions

# A residual within this factor of the one at the last diagnosis has not grown since.
GROWN = 1.2
_BEFORE = 'before the last restart'


def report_model(pipeline, written, base, simulated):
    """
    Return (level, message, values) about a Pipeline's model.

    written: time its file was last written [s since 1970]; base: StampBase of the input;
    simulated: whether time comes from a simulator.
    """
    watch, model = pipeline.watch, pipeline.model
    ratio, residual = (np.where(watch.enough, x, np.nan) for x in (watch.ratio, watch.residual))
    values = _of_joints('residual ratio {}', model, ratio)
    values |= _of_joints('residual {} [Nm]', model, residual)
    values |= _of_joints('residual {} at the last diagnosis [Nm]', model, _diagnosed(model))
    values |= _of_joints('motion judged {} [s]', model, watch.seconds)
    values['file'] = pipeline.model_file
    values['written'] = _date(written)
    values['diagnosed'] = model.diagnosed or 'not known'
    values['recordings'] = ', '.join(model.recording_names) or 'none'
    told = []
    if aged := watch.aged:
        first = min(joint.since for joint in aged)
        values['aged since'] = _BEFORE if first == EARLIER else _date(_wall(first, base))
        told = [f'{_told(a, base)}{_since_diagnosis(a, model)}' for a in aged]
        told[0] = f'model has aged: {told[0]}'
    told += cautions(model, simulated)
    if told:
        return WARN, '; '.join(told), values
    if not watch.enough.all():
        few = [joint for joint, enough in zip(model.robot.joints, watch.enough) if not enough]
        return OK, f'too little motion yet to judge {", ".join(few)}', values
    return OK, 'residuals are what the model states', values


def told_of_model(pipeline):
    """Return in words which model is at work and where it comes from."""
    names = pipeline.model.recording_names
    return f'{pipeline.model_file} (identified from {", ".join(names) or "no recordings"})'


def _of_joints(key, model, numbers):
    """Return {key with the joint's name: number}, without what is not known."""
    return {key.format(joint): float(number)
            for joint, number in zip(model.robot.joints, numbers) if np.isfinite(number)}


def _diagnosed(model):
    """Return the residual (n,) [Nm] at the last diagnosis, NaN where it is not known."""
    known = model.residuals.sliding
    return np.full(model.robot.n, np.nan) if known is None else known


def _told(aged, base):
    since = (_BEFORE if aged.since == EARLIER else
             datetime.fromtimestamp(_wall(aged.since, base)).strftime('%H:%M:%S'))
    return (f'{aged.joint} residual {aged.ratio:.1f} times the stated since {since} '
            f'({aged.motion:.0f} s of motion)')


def _since_diagnosis(aged, model):
    """Return in words how a joint's residual compares with the last diagnosis, if it is known."""
    then = _diagnosed(model)[model.robot.joints.index(aged.joint)]
    if model.diagnosed is None or not np.isfinite(then):
        return ''
    day = datetime.fromisoformat(model.diagnosed).strftime('%Y-%m-%d %H:%M')
    if aged.residual > GROWN * then:
        return (f', since the diagnosis of {day} residual of {aged.joint} has grown from '
                f'{then:.3g} to {aged.residual:.3g} Nm')
    return f', at the diagnosis of {day} it was {then:.3g} Nm already, now {aged.residual:.3g} Nm'


def _wall(seconds, base):
    stamp = base.message(seconds)
    return stamp.sec + 1e-9 * stamp.nanosec


def _date(seconds):
    return datetime.fromtimestamp(seconds).astimezone().isoformat(timespec='seconds')
