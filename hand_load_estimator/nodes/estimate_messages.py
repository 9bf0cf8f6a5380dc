"""A LoadEstimate as the messages of the ROS interface."""

from array import array

from geometry_msgs.msg import Inertia, InertiaStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, MultiArrayLayout

from ..load import MESSAGE_ORDER
from .diagnostics import ERROR, OK, STALE, WARN, status_message

# The message has no field for them, so the labels carry order and frame.
_LABELS = ','.join(MESSAGE_ORDER)
_LAYOUT = MultiArrayLayout(dim=[MultiArrayDimension(label=f'rows:{_LABELS}', size=10, stride=100),
                                MultiArrayDimension(label=f'columns:{_LABELS}', size=10,
                                                    stride=10)])

# Keys of the status that tell masses [kg] held beside the estimate.
TARED, TOOL = KNOWN_MASSES = 'tared mass [kg]', 'tool mass [kg]'

_LEVELS = {'NO_DATA': WARN, 'STALE_INPUT': STALE, 'MODEL_MISMATCH': ERROR}


def inertia_message(vector, stamp, frame):
    """Return InertiaStamped of a (10,) vector in message order."""
    m, x, y, z, ixx, ixy, ixz, iyy, iyz, izz = (float(value) for value in vector)
    out = InertiaStamped()
    out.header.stamp, out.header.frame_id = stamp, frame
    out.inertia = Inertia(m=m, ixx=ixx, ixy=ixy, ixz=ixz, iyy=iyy, iyz=iyz, izz=izz)
    out.inertia.com.x, out.inertia.com.y, out.inertia.com.z = x, y, z
    return out


def vector_of_inertia(inertia):
    """Return the list of ten in message order of a geometry_msgs/Inertia."""
    com = inertia.com
    return [inertia.m, com.x, com.y, com.z, inertia.ixx, inertia.ixy, inertia.ixz, inertia.iyy,
            inertia.iyz, inertia.izz]


def covariance_message(covariance):
    """Return Float64MultiArray of a (10, 10) covariance in message order, row-major."""
    return Float64MultiArray(layout=_LAYOUT, data=array('d', covariance.tobytes()))


def residual_message(joints, residual, stamp):
    """Return JointState whose effort is tau_real - tau_mdl (n,) [Nm]; NaN before data."""
    out = JointState(name=joints, effort=array('d', residual.tobytes()))
    out.header.stamp = stamp
    return out


def estimate_status(name, estimate, age, method, tared_mass, more=()):
    """
    Return DiagnosticStatus of an estimate.

    age [s]: time since the newest measurement in it, NaN before data; method: name of the
    estimator in use; tared_mass [kg]: what tare declared zero; more: further
    (key, value) pairs.
    """
    values = {'determined': ' '.join('1' if d else '0' for d in estimate.determined),
              'age': age, 'reason': estimate.reason, 'load_id': estimate.load_id,
              'method': method, TARED: tared_mass, **dict(more)}
    return status_message(name, _LEVELS.get(estimate.status, OK), estimate.status, values)
