"""The rigid arm in MuJoCo: a serial chain with rotors and a load body that can be exchanged."""

import mujoco
import numpy as np

from ..load import LoadParameters

LOAD = 'load'
# MuJoCo refuses moving bodies without mass; this much cannot be felt.
_LEAST_MASS, _LEAST_INERTIA = 1e-6, 1e-9


def _quaternion(rotation):
    out = np.empty(4)
    mujoco.mju_mat2Quat(out, np.ascontiguousarray(rotation).ravel())
    return out


def _principal(tensor):
    """Return moments (3,) and quaternion (4,) of the principal axes of an inertia (3, 3)."""
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return moments, _quaternion(axes)


def _inertial(pseudo):
    """Return mass, centre (3,), moments (3,), quaternion (4,) of a pseudo-inertia (4, 4)."""
    mass = max(pseudo[3, 3], _LEAST_MASS)
    com = pseudo[:3, 3] / mass
    second = pseudo[:3, :3] - mass * np.outer(com, com)
    moments, axes = _principal(np.trace(second) * np.eye(3) - second)
    return mass, com, np.maximum(moments, _LEAST_INERTIA), axes


def _joint_axis(model, j):
    """Return (MuJoCo joint type, axis (3,)) of joint j of a pinocchio model."""
    data = model.joints[j].createData()
    model.joints[j].calc(data, np.zeros(1))
    motion = np.array(data.S).ravel()
    if np.any(motion[3:]):
        return mujoco.mjtJoint.mjJNT_HINGE, motion[3:]
    return mujoco.mjtJoint.mjJNT_SLIDE, motion[:3]


def chain_spec(robot, links, rotor, gravity):
    """
    Return the MjSpec of the chain with a body LOAD; no contacts, limits or passive forces.

    links (n, 4, 4): pseudo-inertias; rotor (n,) [kg m^2]; gravity (3,) [m/s^2].
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = gravity
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    # A nominal link that breaks the triangle inequality (some URDFs have one) is repaired.
    spec.compiler.balanceinertia = True
    body = spec.worldbody
    for j, name in enumerate(robot.joints, start=1):
        place = robot.model.jointPlacements[j]
        mass, com, moments, axes = _inertial(links[j - 1])
        body = body.add_body(name=f'link {name}', pos=place.translation,
                             quat=_quaternion(place.rotation), mass=mass, ipos=com,
                             inertia=moments, iquat=axes, explicitinertial=True)
        kind, axis = _joint_axis(robot.model, j)
        body.add_joint(name=name, type=kind, axis=axis, armature=rotor[j - 1])
    frame = robot.model.frames[robot.model.getFrameId(robot.load_frame)].placement
    # Off its frame in place and axes, so that MuJoCo keeps them free to be written later.
    body.add_body(name=LOAD, pos=frame.translation, quat=_quaternion(frame.rotation),
                  mass=1.0, ipos=[0.01, 0.02, 0.03], inertia=[0.01, 0.02, 0.025],
                  iquat=[0.8, 0.36, 0.48, 0.0], explicitinertial=True)
    return spec


class Arm:
    """
    Rigid-body state and forward dynamics of the true arm.

    position, velocity, acceleration (n,) are views of MuJoCo's state: write position and
    velocity, then call `accelerate`.
    """

    def __init__(self, robot, links, rotor, gravity):
        self._model = chain_spec(robot, links, rotor, gravity).compile()
        self._data = mujoco.MjData(self._model)
        self._body = self._model.body(LOAD).id
        self.position, self.velocity = self._data.qpos, self._data.qvel
        self.acceleration, self._applied = self._data.qacc, self._data.qfrc_applied
        self._jacobian = np.zeros((3, robot.n))
        self._step = np.zeros(robot.n)
        self.attach(LoadParameters())

    def attach(self, load):
        """Put LoadParameters on the hand in place of what is there; zero mass is nothing."""
        moments, axes = _principal(load.inertia)
        self._model.body_mass[self._body] = load.mass
        self._model.body_ipos[self._body] = load.com
        self._model.body_inertia[self._body] = np.maximum(moments, 0.0)
        self._model.body_iquat[self._body] = axes
        # Derived constants (subtree masses) follow; scratch data, because the call moves the arm.
        mujoco.mj_setConst(self._model, mujoco.MjData(self._model))

    def accelerate(self, torque):
        """Return the acceleration (n,) under joint torque (n,) beside gravity."""
        self._applied[:] = torque
        mujoco.mj_forward(self._model, self._data)
        return self.acceleration

    def integrate(self, dt):
        """Advance dt [s] with the acceleration last computed (semi-implicit Euler)."""
        step = self._step
        np.multiply(self.acceleration, dt, out=step)
        self.velocity += step
        np.multiply(self.velocity, dt, out=step)
        self.position += step

    def hold_torque(self):
        """Return the torque (n,) that holds the arm still; `accelerate` is due afterwards."""
        speed = self.velocity.copy()
        self.velocity[:] = 0.0
        mujoco.mj_forward(self._model, self._data)
        torque = self._data.qfrc_bias.copy()
        self.velocity[:] = speed
        return torque

    def required_torque(self, position, velocity, acceleration):
        """Return the torque (n,) that a motion takes, against gravity too; `accelerate` is due."""
        self.position[:], self.velocity[:] = position, velocity
        self.acceleration[:] = acceleration
        mujoco.mj_inverse(self._model, self._data)
        return self._data.qfrc_inverse.copy()

    def hand(self):
        """Return position (3,), rotation (3, 3), Jacobian (3, n) of the load frame's origin."""
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_jacBody(self._model, self._data, self._jacobian, None, self._body)
        return (self._data.xpos[self._body], self._data.xmat[self._body].reshape(3, 3),
                self._jacobian)
