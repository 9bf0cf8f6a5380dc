"""
Load parameters: the only module that knows parameter orders and reference points.

Three vectors of ten describe the same rigid load, all in the axes of the load frame:

* message order (interfaces): m, x, y, z, ixx, ixy, ixz, iyy, iyz, izz with the inertia about the
  centre of mass, as geometry_msgs/Inertia defines it;
* products (formulas, symbol m in eq. 10-14): m, m x, m y, m z, Ixx, Ixy, Iyy, Ixz, Iyz, Izz with
  the inertia about the frame origin, in pinocchio's order; torque is linear in them;
* shape: m, x, y, z, gxx, gxy, gxz, gyy, gyz, gzz with g = inertia about the centre of mass
  divided by the mass [m^2]; priors are stated in it, because what a hand can hold has a size and
  a place whatever it weighs.
"""

from dataclasses import dataclass, field

import numpy as np

MESSAGE_ORDER = ('m', 'x', 'y', 'z', 'ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')
PRODUCT_ORDER = ('m', 'mx', 'my', 'mz', 'Ixx', 'Ixy', 'Iyy', 'Ixz', 'Iyz', 'Izz')

# row, column of the symmetric tensor for each place of the six in message order
_MESSAGE_TENSOR = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
_PRODUCT_TENSOR = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
_PRODUCT_OF_MESSAGE = np.array([4 + _PRODUCT_TENSOR.index(ij) for ij in _MESSAGE_TENSOR])
_MESSAGE_OF_PRODUCT = np.array([4 + _MESSAGE_TENSOR.index(ij) for ij in _PRODUCT_TENSOR])
# Steiner's term of each second moment in product order is c^T _STEINER[k] c per mass.
_STEINER = np.array([(i == j) * np.eye(3) - 0.5 * (np.outer(np.eye(3)[i], np.eye(3)[j])
                                                   + np.outer(np.eye(3)[j], np.eye(3)[i]))
                     for i, j in _PRODUCT_TENSOR])
_OF_PAIRS = np.ascontiguousarray(_STEINER.reshape(6, 9).T)


def _read_only(value, shape, what):
    array = np.array(value, dtype=float)
    if array.shape != shape:
        raise ValueError(f'{what} has shape {array.shape}, expected {shape}')
    array.setflags(write=False)
    return array


def _tensor(six):
    tensor = np.empty((3, 3))
    for value, (i, j) in zip(six, _MESSAGE_TENSOR):
        tensor[i, j] = tensor[j, i] = value
    return tensor


def _six(tensor):
    return np.array([tensor[i, j] for i, j in _MESSAGE_TENSOR])


def _second_moments(inertia):
    return 0.5 * np.trace(inertia) * np.eye(3) - inertia


# Entries of the second moments (9), row by row, of each of the six in message order.
_SECOND_MOMENTS = np.array([_second_moments(_tensor(six)).ravel() for six in np.eye(6)]).T


def second_moments(six):
    """Return int r r^T dm (3, 3) [kg m^2] of an inertia (6,) in message order."""
    return _SECOND_MOMENTS.dot(six).reshape(3, 3)


def second_moment_row(axis):
    """Return a (6,) with a . inertia in message order = second moment along a unit axis (3,)."""
    return (axis[:, None] * axis).ravel().dot(_SECOND_MOMENTS)


def inertia_of_second_moments(moments):
    """Return the inertia (6,) in message order of second moments (3, 3)."""
    return _six(np.trace(moments) * np.eye(3) - moments)


@dataclass(frozen=True)
class LoadParameters:
    """
    One rigid load in the axes of the load frame.

    mass [kg]; com (3,) [m]; inertia (3, 3) about the centre of mass [kg m^2].
    """

    mass: float = 0.0
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self):
        object.__setattr__(self, 'mass', float(self.mass))
        object.__setattr__(self, 'com', _read_only(self.com, (3,), 'com'))
        object.__setattr__(self, 'inertia', _read_only(self.inertia, (3, 3), 'inertia'))

    @staticmethod
    def from_message(vector):
        """Return the load of a (10,) vector in message order."""
        vector = np.asarray(vector, dtype=float)
        return LoadParameters(vector[0], vector[1:4], _tensor(vector[4:]))

    def to_message(self):
        """Return the (10,) vector in message order."""
        return np.concatenate([[self.mass], self.com, _six(self.inertia)])

    def to_products(self):
        """Return the (10,) products (inertia about the frame origin, pinocchio's order)."""
        return products_from_message(self.to_message())

    def is_physical(self):
        """Tell whether a body with this mass distribution can exist."""
        if not np.all(np.isfinite(self.to_message())) or self.mass < 0.0:
            return False
        if self.mass == 0.0:
            return not np.any(self.inertia)
        with np.errstate(over='ignore', invalid='ignore'):
            moments = _second_moments(self.inertia)
        return bool(np.isfinite(moments).all() and np.linalg.eigvalsh(moments)[0] >= -1e-9)


def products_from_message(vector):
    """Return (..., 10) products of (..., 10) vectors in message order."""
    vector = np.asarray(vector, dtype=float)
    m, c = vector[..., :1], vector[..., 1:4]
    out = np.empty_like(vector)
    out[..., :1] = m
    out[..., 1:4] = m * c
    out[..., 4:] = vector[..., _MESSAGE_OF_PRODUCT] + m * _steiner(c)
    return out


def _steiner(c):
    """Return (..., 6) in product order: inertia per mass that a shift by c (..., 3) adds."""
    return (c[..., :, None] * c[..., None, :]).reshape(c.shape[:-1] + (9,)) @ _OF_PAIRS


def message_from_products(products):
    """
    Return (..., 10) vectors in message order of (..., 10) products.

    Where the mass is zero the centre of mass has no meaning; it comes out as zero.
    """
    products = np.asarray(products, dtype=float)
    m = products[..., :1]
    there = np.abs(m) > 1e-12
    c = np.where(there, products[..., 1:4] / np.where(there, m, 1.0), 0.0)
    out = np.empty_like(products)
    out[..., :1] = m
    out[..., 1:4] = c
    out[..., 4:] = (products[..., 4:] - m * _steiner(c))[..., _PRODUCT_OF_MESSAGE - 4]
    return out


def message_from_shape(shape):
    """Return (..., 10) message vectors of (..., 10) shape vectors (inertia = mass x g)."""
    shape = np.asarray(shape, dtype=float)
    out = shape.copy()
    out[..., 4:] = shape[..., :1] * shape[..., 4:]
    return out


def message_jacobian_of_shape(shape):
    """Return d message / d shape, (..., 10, 10)."""
    shape = np.asarray(shape, dtype=float)
    jacobian = np.zeros(shape.shape + (10,))
    diagonal = np.einsum('...ii->...i', jacobian)
    diagonal[..., :4] = 1.0
    diagonal[..., 4:] = shape[..., :1]
    jacobian[..., 4:, 0] = shape[..., 4:]
    return jacobian


def _jacobian_coefficients():
    """Return (31, 10, 10): d products / d shape as coefficients of _terms()."""
    # Pairs of (1, m, x, y, z), then g; no entry needs more than that.
    pairs, g = np.zeros((5, 5, 10, 10)), np.zeros((6, 10, 10))
    pairs[0, 0, 0, 0] = 1.0
    for axis in range(3):
        pairs[0, 2 + axis, 1 + axis, 0] = pairs[0, 1, 1 + axis, 1 + axis] = 1.0
    for k, place in enumerate(_MESSAGE_OF_PRODUCT):
        g[place - 4, 4 + k, 0] = pairs[0, 1, 4 + k, place] = 1.0
        pairs[2:, 2:, 4 + k, 0] = _STEINER[k]
        pairs[1, 2:, 4 + k, 1:4] = 2.0 * _STEINER[k]
    return np.concatenate([pairs.reshape(25, 10, 10), g])


_JACOBIAN = _jacobian_coefficients().reshape(31, 100)
# The first column of the Jacobian is h of products = mass h(shape).
_PER_MASS = np.ascontiguousarray(_JACOBIAN[:, ::10])


# Of each monomial, which of (1, shape).
_FACTORS = np.array([(i, j) for i in range(5) for j in range(5)]
                    + [(0, k) for k in range(5, 11)]).T


def _terms(shape):
    """Return (..., 1, 31): the monomials that the Jacobian of the products is linear in."""
    lead = np.empty(shape.shape[:-1] + (1, 11))
    lead[..., 0], lead[..., 0, 1:] = 1.0, shape
    return lead.take(_FACTORS[0], -1) * lead.take(_FACTORS[1], -1)


def products_from_shape(shape):
    """Return (..., 10) products of (..., 10) shape vectors."""
    shape = np.asarray(shape, dtype=float)
    return shape[..., :1] * (_terms(shape) @ _PER_MASS)[..., 0, :]


def products_and_jacobian_of_shape(shape):
    """Return products (..., 10) and d products / d shape (..., 10, 10)."""
    shape = np.asarray(shape, dtype=float)
    jacobian = (_terms(shape) @ _JACOBIAN).reshape(shape.shape + (10,))
    return shape[..., :1] * jacobian[..., 0], jacobian


def products_jacobian_of_shape(shape):
    """Return d products / d shape, (..., 10, 10)."""
    return products_and_jacobian_of_shape(shape)[1]


def products_jacobian_of_message(vector):
    """Return d products / d message vector, (..., 10, 10)."""
    vector = np.asarray(vector, dtype=float)
    massless = vector.copy()
    massless[..., 4:] = 0.0
    jacobian = products_jacobian_of_shape(massless)
    # The inertia stands beside the mass here, not per mass.
    jacobian[..., range(4, 10), _MESSAGE_OF_PRODUCT] = 1.0
    return jacobian


def pseudo_inertia(products):
    """Return the (4, 4) pseudo-inertia of (10,) products; positive definite = physical."""
    p = np.asarray(products, dtype=float)
    about_origin = np.empty((3, 3))
    for k, (i, j) in enumerate(_PRODUCT_TENSOR):
        about_origin[i, j] = about_origin[j, i] = p[4 + k]
    out = np.empty((4, 4))
    out[:3, :3] = _second_moments(about_origin)
    out[:3, 3] = out[3, :3] = p[1:4]
    out[3, 3] = p[0]
    return out


def _products_of_pseudo_inertia(pseudo):
    second = pseudo[:3, :3]
    about_origin = np.trace(second) * np.eye(3) - second
    return np.concatenate([[pseudo[3, 3]], pseudo[:3, 3],
                           [about_origin[i, j] for i, j in _PRODUCT_TENSOR]])


def products_transform(rotation, translation):
    """
    Return the (10, 10) matrix that re-expresses products in another frame.

    rotation (3, 3), translation (3,): pose of the given frame in the wanted one.
    """
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    columns = [_products_of_pseudo_inertia(pose @ pseudo_inertia(basis) @ pose.T)
               for basis in np.eye(10)]
    return np.array(columns).T


def together(loads):
    """Return the LoadParameters of several that hang in the same load frame."""
    if len(loads) == 1:
        return loads[0]
    return LoadParameters.from_message(
        message_from_products(sum(load.to_products() for load in loads)))


STATUSES = ('NO_DATA', 'WAITING_FOR_MOTION', 'ESTIMATING', 'DETERMINED', 'LOAD_CHANGED',
            'MODEL_MISMATCH', 'STALE_INPUT')


@dataclass(frozen=True)
class LoadEstimate:
    """
    What is known of the load at one moment.

    stamp [s]; mean (10,) and covariance (10, 10) in message order; determined (10,) bool;
    status one of STATUSES; reason a sentence; load_id counts the load changes seen.
    """

    stamp: float
    mean: np.ndarray
    covariance: np.ndarray
    determined: np.ndarray
    status: str
    reason: str = ''
    load_id: int = 0

    def __post_init__(self):
        object.__setattr__(self, 'mean', _read_only(self.mean, (10,), 'mean'))
        object.__setattr__(self, 'covariance',
                           _read_only(self.covariance, (10, 10), 'covariance'))
        determined = np.array(self.determined, dtype=bool)
        determined.setflags(write=False)
        object.__setattr__(self, 'determined', determined)
        if self.status not in STATUSES:
            raise ValueError(f'status {self.status!r} is not one of {STATUSES}')

    @property
    def std(self):
        """Standard deviations (10,) in message order."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def load(self):
        """The mean as LoadParameters."""
        return LoadParameters.from_message(self.mean)
