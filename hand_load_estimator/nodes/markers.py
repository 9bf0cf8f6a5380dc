"""An estimate as RViz markers: where the load is, how sure that is, and how it is spread."""

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

_LIFETIME = Duration(sec=1)  # a stopped estimator must not leave a picture that looks alive
_DENSITY = 4.0 / 3.0 * np.pi * 7000.0  # [kg/m^3] the sphere looks like a ball of steel
_SMALLEST = 1e-3  # [m] RViz refuses a scale of zero


def _quaternion(rotation):
    """Return the quaternion of a proper rotation matrix (3, 3), by its largest component."""
    r = rotation
    four = 0.25 * np.array([1 + r[0, 0] + r[1, 1] + r[2, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2],
                            1 - r[0, 0] + r[1, 1] - r[2, 2], 1 - r[0, 0] - r[1, 1] + r[2, 2]])
    k = int(np.argmax(four))
    rows = ([4 * four[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], 4 * four[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 4 * four[2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 4 * four[3]])
    w, x, y, z = (float(value) for value in np.array(rows[k]) / np.linalg.norm(rows[k]))
    return Quaternion(x=x, y=y, z=z, w=w)


def _principal(tensor):
    """Return eigenvalues (3,), not below zero, and a proper rotation (3, 3) to their axes."""
    values, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return np.maximum(values, 0.0), axes


def equivalent_ellipsoid(mass, inertia):
    """Return diameters (3,) [m] and axes (3, 3) of the solid ellipsoid with this inertia."""
    moments, axes = _principal(inertia)
    if mass <= 0.0:
        return np.zeros(3), axes
    squares = 2.5 / mass * (np.sum(moments) - 2.0 * moments)
    return 2.0 * np.sqrt(np.maximum(squares, 0.0)), axes


def _marker(number, kind, header, position, scale, color):
    x, y, z = (float(value) for value in position)
    sx, sy, sz = (float(max(value, _SMALLEST)) for value in scale)
    out = Marker(ns='hand_load', id=number, type=kind, action=Marker.ADD, lifetime=_LIFETIME,
                 color=ColorRGBA(**dict(zip('rgba', color))), scale=Vector3(x=sx, y=sy, z=sz))
    out.header = header
    out.pose.position = Point(x=x, y=y, z=z)
    return out


def estimate_markers(estimate, header):
    """Return MarkerArray: centre of mass, its 2-sigma ellipsoid, inertia ellipsoid, text."""
    mass, com = float(estimate.mean[0]), estimate.mean[1:4]
    radius = (max(mass, 0.0) / _DENSITY) ** (1.0 / 3.0)
    ball = _marker(0, Marker.SPHERE, header, com, [2.0 * radius] * 3, (0.2, 0.4, 1.0, 1.0))
    spread, axes = _principal(estimate.covariance[1:4, 1:4])
    # Two sigma to each side.
    doubt = _marker(1, Marker.SPHERE, header, com, 4.0 * np.sqrt(spread), (1.0, 0.7, 0.0, 0.3))
    doubt.pose.orientation = _quaternion(axes)
    diameters, axes = equivalent_ellipsoid(mass, estimate.load.inertia)
    body = _marker(2, Marker.SPHERE, header, com, diameters, (0.2, 0.8, 0.3, 0.3))
    body.pose.orientation = _quaternion(axes)
    text = _marker(3, Marker.TEXT_VIEW_FACING, header, com + [0.0, 0.0, 0.15], [0.05] * 3,
                   (1.0, 1.0, 1.0, 1.0))
    text.text = f'{mass:.2f} ± {2.0 * estimate.std[0]:.2f} kg\n{estimate.status}'
    return MarkerArray(markers=[ball, doubt, body, text])
