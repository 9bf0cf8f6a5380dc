"""Rigid-body mechanics of an arm described by a robot file (pinocchio)."""

from functools import cached_property
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from .errors import ConfigurationError
from .files.link_masses import refuse_masses
from .files.robot_file import JointLimits, parse_robot, read_robot_file
from .load import products_transform


def _parsed(urdf):
    try:
        return ElementTree.fromstring(urdf)
    except ElementTree.ParseError:
        return None  # pinocchio says what is wrong with it


def _with_angles(root):
    """Return a URDF's text with continuous joints as revolute ones: here an angle is an angle."""
    for joint in root.iter('joint'):
        if joint.get('type') == 'continuous':
            joint.set('type', 'revolute')
            if joint.find('limit') is None:
                ElementTree.SubElement(joint, 'limit', effort='0', velocity='0')
    return ElementTree.tostring(root, encoding='unicode')


def _build_model(file):
    """Return the pinocchio model with only the robot file's joints, in their order."""
    root = _parsed(file.urdf)
    where = f'{file.where}: urdf'
    try:
        full = pin.buildModelFromXML(file.urdf if root is None else _with_angles(root))
    except (ValueError, RuntimeError) as error:
        raise ConfigurationError(where, f'is not a usable URDF ({error})') from None
    movable = [name for name in full.names if name != 'universe']
    missing = [name for name in file.joints if name not in movable]
    if missing:
        raise ConfigurationError(f'{file.where}: joints', f'not in the URDF: {", ".join(missing)}',
                                 allowed=', '.join(movable))
    locked = [full.getJointId(name) for name in movable if name not in file.joints]
    model = pin.buildReducedModel(full, locked, pin.neutral(full))
    if model.nq != len(file.joints) or model.nv != model.nq:
        raise ConfigurationError(where, 'has joints with more than one degree of freedom',
                                 allowed='revolute and prismatic joints')
    order = [name for name in model.names if name != 'universe']
    if tuple(order) != file.joints:
        raise ConfigurationError(f'{file.where}: joints', 'are not in the order of the chain',
                                 list(file.joints), ', '.join(order))
    for j in range(1, model.njoints):
        if model.parents[j] != j - 1:
            raise ConfigurationError(where, 'branches', allowed='a serial chain of the joints '
                                     'named in `joints`')
    if not model.existFrame(file.load_frame):
        raise ConfigurationError(f'{file.where}: load_frame', 'is not in the URDF',
                                 file.load_frame, ', '.join(f.name for f in model.frames))
    if root is not None:
        refuse_masses(root, file.joints, where)
    model.gravity.linear = np.array(file.gravity)
    return model


def _stops(model):
    lower, upper = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy()
    free = ~np.isfinite(lower) | ~np.isfinite(upper) | (lower >= upper)
    lower[free], upper[free] = -np.inf, np.inf
    return np.array([lower, upper])


def _limits(file, stops):
    # A continuous joint comes without limits; one turn each way is enough for any motion here.
    turn = 2.0 * np.pi
    lower, upper = np.where(np.isfinite(stops), stops, [[-turn], [turn]])
    return JointLimits(lower, upper, file.max_velocity, file.max_acceleration,
                       file.max_torque, file.allowed_torque)


class Robot:
    """
    An arm: names, limits, nominal inverse dynamics and the load regressor K.

    stops (2, n) [rad]: least and greatest positions by the URDF, infinite where it states none;
    turning (n,) bool: joints that turn and do not slide;
    load_placement: pinocchio.SE3 of the load frame behind the last joint.
    Not thread-safe: pinocchio's work space is reused between calls.
    """

    def __init__(self, file):
        self.file = file
        self.name, self.joints, self.n = file.name, file.joints, len(file.joints)
        self.effort, self.rated_load = file.effort, file.rated_load
        self.load_frame = file.load_frame
        self.reference_temperature = file.reference_temperature
        self.model = _build_model(file)
        self.stops = _stops(self.model)
        self.limits = _limits(file, self.stops)
        self.turning = np.array([joint.shortname().startswith('JointModelR')
                                 for joint in list(self.model.joints)[1:]])
        self._data = self.model.createData()
        # The same arm under the two parts of gravity's change by a turn.
        self._turned, self._turned_by = (self.model.copy(), self.model.copy()), None
        frame = self.model.frames[self.model.getFrameId(file.load_frame)]
        if frame.parentJoint != self.n:
            raise ConfigurationError(f'{file.where}: load_frame', 'is not fixed to the last joint',
                                     file.load_frame, f'a frame behind {self.joints[-1]}')
        self.load_placement = frame.placement
        self._load_to_link = products_transform(frame.placement.rotation,
                                                frame.placement.translation)
        self.nominal_links = np.concatenate(
            [self.model.inertias[j].toDynamicParameters() for j in range(1, self.n + 1)])

    def link_regressor(self, q, v, a):
        """Return Y (n, 10 n): torque = Y @ link products (10 n,), pinocchio's order."""
        return pin.computeJointTorqueRegressor(self.model, self._data, q, v, a).copy()

    def load_regressor(self, q, v, a):
        """Return K (n, 10): torque of a load = K @ its products in the load frame (eq. 10)."""
        return self.load_columns(self.link_regressor(q, v, a))

    def load_columns(self, link_regressor):
        """Return K (..., n, 10) from already computed link regressors (..., n, 10 n)."""
        return link_regressor[..., -10:] @ self._load_to_link

    def configured_torque(self, q):
        """
        Return (n,) [Nm]: gravity torque at q that the driver has taken off the effort.

        Of effort.configured_load; zeros where there is none.
        """
        if self.effort.configured_load is None:
            return np.zeros(self.n)
        zero = np.zeros(self.n)
        return self.load_regressor(q, zero, zero) @ self.effort.configured_load.to_products()

    def in_last_link(self, products):
        """Return products (10,) of a load as the last link's, pinocchio's order."""
        return self._load_to_link @ products

    def gravity_loaded(self, q):
        """
        Tell which joints (n,) bool carry a load's weight at q.

        Those with at least a tenth of the largest gravity torque of the rated load: the joints
        whose motion tells a mass.
        """
        zero = np.zeros(self.n)
        torque = np.abs(self.load_regressor(q, zero, zero) @ self.rated_load.to_products())
        return torque >= 0.1 * torque.max()

    def rigid_torque(self, q, v, a, load=None):
        """Return the torque (n,) of the nominal links and an optional LoadParameters."""
        tau = pin.rnea(self.model, self._data, q, v, a).copy()
        if load is not None:
            tau += self.load_regressor(q, v, a) @ load.to_products()
        return tau

    def tilt_regressor(self, q, links, angles=(0.0, 0.0)):
        """
        Return (n, 2) [Nm/rad]: columns for what turned gravity does to the torque of links.

        links (10 n,): products; angles (2,) [rad]: about the tilt axes, as one rotation vector.
        The columns times these angles are all that the turn changes; at zero, to first order.
        """
        return np.array([y @ links for y in self._tilted(q, angles)]).T

    def tilted_load_columns(self, q, angles=(0.0, 0.0)):
        """Return (2, n, 10): the same of a load, as columns for its products."""
        return np.array([self.load_columns(y) for y in self._tilted(q, angles)])

    def tilt_axes(self):
        """
        Return (2, 3): axes about which gravity may be turned; for a level base x and y.

        The base axis least along gravity, and the one across both.
        """
        down = self.model.gravity.linear / np.linalg.norm(self.model.gravity.linear)
        first = np.eye(3)[np.argmin(np.abs(down))]
        first = first - (first @ down) * down
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(first, down)])

    def _gravity_changes(self, angles):
        """
        Return (2, 3): vectors whose sum, weighed with angles (2,) [rad], is gravity's change.

        Rodrigues' rotation; its axis lies across gravity, which leaves sine and cosine. A load's
        weight loses 1 - cosine even where the links' masses were fitted without it.
        """
        gravity, size = self.model.gravity.linear, np.linalg.norm(angles)
        shortened = 0.5 * np.sinc(0.5 * size / np.pi) ** 2 * np.outer(angles, gravity)
        return np.sinc(size / np.pi) * np.cross(self.tilt_axes(), gravity) - shortened

    def turned_gravity(self, angles):
        """Return gravity (3,) [m/s^2] in base axes, turned by angles (2,) as of tilt_regressor."""
        return self.model.gravity.linear + np.asarray(angles) @ self._gravity_changes(angles)

    def _tilted(self, q, angles):
        """Return Y (n, 10 n) at rest in each part of gravity's change."""
        angles, rest = tuple(angles), np.zeros(self.n)
        if angles != self._turned_by:
            for model, change in zip(self._turned, self._gravity_changes(angles)):
                model.gravity.linear = change
            self._turned_by = angles
        return [pin.computeJointTorqueRegressor(model, self._data, q, rest, rest).copy()
                for model in self._turned]

    def hand_jacobian(self, q):
        """Return (3, n): velocity of the load frame's origin, in base axes, per joint speed."""
        return self._hand_jacobian(q)[:3].copy()

    def _hand_jacobian(self, q):
        frame = self.model.getFrameId(self.load_frame)
        return pin.computeFrameJacobian(self.model, self._data, q, frame, pin.LOCAL_WORLD_ALIGNED)

    def hand_wrench_columns(self, q):
        """
        Return (n, 6): joint torque of a force and a moment on the hand of size one each.

        Both act at the load frame's origin, along the base's axes.
        """
        return self._hand_jacobian(q).T.copy()

    def mass_matrix(self, q):
        """Return the joint-space mass matrix (n, n) of the nominal links."""
        upper = np.triu(pin.crba(self.model, self._data, q))
        return upper + np.triu(upper, 1).T

    @cached_property
    def usual_inertia(self):
        """Mean inertia (n,) [kg m^2] of the links about each joint over poses in its range."""
        rng = np.random.default_rng(0)
        poses = rng.uniform(np.maximum(self.limits.lower, -np.pi),
                            np.minimum(self.limits.upper, np.pi), (200, self.n))
        return np.mean([np.diag(self.mass_matrix(q)) for q in poses], axis=0)


def load_robot(path):
    """Return the Robot of a robot file; raises ConfigurationError."""
    return Robot(read_robot_file(path))


def robot_from_content(content, where):
    """Return the Robot of the self-contained mapping kept in a model file."""
    return Robot(parse_robot(content, where))
