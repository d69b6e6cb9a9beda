"""Springs of a robot's suspension."""

from __future__ import annotations

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.engine.engine import GRAVITY_M_S2
from handcart.backends.physics.urdf.sprung import PITCH, ROLL
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .robot_body import RobotBody

DAMPING_RATIO = 0.6
_POSTURES = 200


class SuspensionSprings:
    """Simulated suspension of a base by springs and dampers in roll and pitch.

    The axes of roll and pitch are at the height `lean_pivot_m` of the robot's file. The base tilts under its
    own weight, the weight of the load, and the force at the hand. The springs' stiffness follows from the
    robot's file: averaged over the arm's postures, the weight of the arm alone tilts the base by
    `lean_mrad_per_m` for each metre between the hand and the base's centre. In a single posture the tilt
    differs from this value, because the arm's centre of mass is not at the hand. The base is upright when the
    hand is above the base's centre.
    """

    def __init__(self, robot: RobotFile, arm: ArmModel, body: RobotBody) -> None:
        """Find stiffness and damping; the body settles at its tilt for the arm's current posture."""
        self._joints = body.joints((ROLL, PITCH))
        here = body.joints(arm.joint_names).states()[0]
        rate, self._trim = _weight_by_reach(arm, body)
        for name, angle in zip(arm.joint_names, here, strict=True):
            body.reset(name, float(angle))
        moment, topples, inertia = _load(body, robot.errors.lean_pivot_m)
        self._stiffness = rate / (robot.errors.lean_mrad_per_m / 1e3) + topples
        self._damping = 2 * DAMPING_RATIO * np.sqrt(self._stiffness * inertia)
        lean = (moment - self._trim) / (self._stiffness - topples)
        for name, angle in zip((ROLL, PITCH), lean, strict=True):
            body.reset(name, float(angle))

    @property
    def lean(self) -> tuple[float, float]:
        """Roll and pitch of the base on its suspension, in [rad], positive as in a URDF (right side down,
        front down).
        """
        roll, pitch = self._joints.states()[0]
        return float(roll), float(pitch)

    def act(self) -> None:
        """Apply the torques of springs and dampers for the next part of a control period."""
        self._joints.spring(self._stiffness, self._damping, -self._trim)


def _weight_by_reach(arm: ArmModel, body: RobotBody) -> tuple[float, FloatArray]:
    """Fit a straight line to the torque of the arm's weight on the upright body, over random postures.

    The arm is left in another posture.

    Returns:
        Torque for each metre between the hand and the centre, in [Nm/m], and torque about roll and pitch (2,)
        in [Nm] with the hand over the centre.
    """
    rng = keyed(0, "suspension's postures")
    reaches, moments = [], []
    for _ in range(_POSTURES):
        joints = rng.uniform(arm.lower, arm.upper)
        for name, angle in zip(arm.joint_names, joints, strict=True):
            body.reset(name, float(angle))
        reaches.append(arm.forward(joints)[:2, 3])
        moments.append(_load(body, 0.0)[0])
    reach, moment = np.array(reaches), np.array(moments)
    # Roll is by weight to the left, the other way round; pitch by weight in front.
    off, turns = reach - reach.mean(axis=0), (moment - moment.mean(axis=0)) * (-1.0, 1.0)
    rate = float((off * turns[:, ::-1]).sum() / (off**2).sum())
    trim = moment.mean(axis=0) - rate * reach.mean(axis=0)[::-1] * (-1.0, 1.0)
    return rate, trim


def _load(body: RobotBody, pivot: float) -> tuple[FloatArray, float, FloatArray]:
    """Return the load of the sprung masses in their current posture.

    Returns:
        Torques (2,) about the base's x axis (roll) and y axis (pitch) in [Nm], their growth with the tilt in
        [Nm/rad], and moments of inertia (2,) about both axes in [kg m²].
    """
    base_T_world: Transform = inverse(body.base_pose())
    moment, topples, inertia = np.zeros(2), 0.0, np.zeros(2)
    for link, mass in body.sprung_masses().items():
        x, y, z = (base_T_world @ body.middle_of_mass(link))[:3, 3]
        moment += mass * GRAVITY_M_S2 * np.array([-y, x])
        topples += mass * GRAVITY_M_S2 * float(z - pivot)
        inertia += mass * (np.array([y, x]) ** 2 + (z - pivot) ** 2)
    return moment, topples, inertia
