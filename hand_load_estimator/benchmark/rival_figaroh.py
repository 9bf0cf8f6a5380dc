"""
FIGAROH as a rival: its regressor, its standard deviations, its physical projection.

FIGAROH 1.0 identifies an arm's base parameters from its own torque recordings. It has no call
that returns an unknown load: the one place that knows a payload, build_total_regressor_current,
scales currents by a payload of known mass (`mass_load`). So its parts are put together here as a
user would who wants a load: RegressorBuilder over the loaded run, of which the last body's ten
columns are the load's; weighted least squares of the torque that the identified model without
load leaves; relative_stdev for the uncertainty; project_p10_lmi for a possible body.
"""

from types import SimpleNamespace

from figaroh.identification.identification_tools import relative_stdev
from figaroh.identification.physical_consistency import project_p10_lmi
from figaroh.tools.regressor import RegressorBuilder, RegressorConfig
import numpy as np

from ..load import message_from_products


def identify_load(robot, run):
    """Return mean (10,) and std (10,) in message order of the load in a LoadedRun."""
    arm = SimpleNamespace(model=robot.model, data=robot.model.createData())
    builder = RegressorBuilder(arm, RegressorConfig())
    rows = builder.build_basic_regressor(run.q, run.v, run.a, {'act_idxv': []})
    # FIGAROH stacks joint by joint.
    weight = run.weight.T.ravel()
    used = weight > 0.0
    columns = robot.load_columns(rows[used]) * weight[used, None]
    torque = run.torque.T.ravel()[used] * weight[used]
    if np.linalg.matrix_rank(columns) < 10:
        raise ValueError('the motion so far does not settle all ten parameters')
    free = np.linalg.lstsq(columns, torque, rcond=None)[0]
    percent = relative_stdev(columns, free, torque)
    possible, report = project_p10_lmi(free)
    if report.status == 'error':
        raise ValueError(f'project_p10_lmi: {report.message}')
    return message_from_products(possible), _message_std(possible,
                                                         0.01 * percent * np.abs(free))


def _message_std(products, std):
    """Return standard deviations in message order; the products' count as independent."""
    step, mean = 1e-6, message_from_products(products)
    slope = np.array([(message_from_products(products + step * e) - mean) / step
                      for e in np.eye(10)]).T
    return np.sqrt((slope ** 2) @ (std ** 2))
