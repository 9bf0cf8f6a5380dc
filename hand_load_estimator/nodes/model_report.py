"""What /diagnostics says of the torque model: whether it has aged, which file, from what."""

from datetime import datetime

from .diagnostics import OK, WARN


def report_model(pipeline, written, base):
    """
    Return (level, message, values) about a Pipeline's model.

    written: time its file was last written [s since 1970]; base: StampBase of the input.
    """
    watch = pipeline.watch
    values = {f'residual ratio {joint}': float(ratio)
              for joint, ratio in zip(pipeline.model.robot.joints, watch.ratio)}
    values |= {f'motion judged {joint} [s]': float(seconds)
               for joint, seconds in zip(pipeline.model.robot.joints, watch.seconds)}
    values['file'] = pipeline.model_file
    values['written'] = _date(written)
    values['recordings'] = ', '.join(pipeline.model.recordings) or 'none'
    aged = watch.aged
    if aged:
        values['aged since'] = _date(_wall(min(joint.since for joint in aged), base))
        return WARN, f'model has aged: {", ".join(_told(a, base) for a in aged)}', values
    if not watch.enough.all():
        few = [joint for joint, enough in zip(pipeline.model.robot.joints, watch.enough)
               if not enough]
        return OK, f'too little motion yet to judge {", ".join(few)}', values
    return OK, 'residuals are what the model states', values


def _told(aged, base):
    since = datetime.fromtimestamp(_wall(aged.since, base)).strftime('%H:%M:%S')
    return (f'{aged.joint} residual {aged.ratio:.1f} times the stated since {since} '
            f'({aged.motion:.0f} s of motion)')


def _wall(seconds, base):
    stamp = base.message(seconds)
    return stamp.sec + 1e-9 * stamp.nanosec


def _date(seconds):
    return datetime.fromtimestamp(seconds).astimezone().isoformat(timespec='seconds')
