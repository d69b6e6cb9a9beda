"""The arm of the simulated robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.urdf.sound_urdf import DEFAULT_HOLDING_EFFORT
from handcart.backends.simulation.body.simulated_parts import SimulatedArm
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_tree import followers_of
from handcart.robotics.numerics.arrays import FloatArray

from .robot_body import RobotBody

CATCHES_UP = 0.02  # time constant of the position loop [s]
CATCH_UP_SPEED_RATIO = 1.2  # times as fast as it may go, a drive can catch up
# of the way to where it belongs that a joint that mimics another makes in a step of the solver
MIMIC_STEP_RATIO = 0.1


class PhysicsArm(SimulatedArm):
    """Arm in a physics engine, with position control, and gravity compensation of arm and load.

    Between two commands the set-point moves at constant speed. A drive is a velocity servo. Its torque limit
    grows with the distance from the set-point, up to the URDF's effort, so it yields at an obstacle like a
    spring.
    """

    STATE: ClassVar = {**SimulatedArm.STATE, "load": tuple[float, FloatArray]}

    def __init__(
        self,
        robot: RobotFile,
        model: ArmModel,
        body: RobotBody,
        felt: Callable[[], FloatArray],
        ahead: float,
        seed: int,
    ) -> None:
        """Take over the arm's joints at their current positions.

        Args:
            robot: robot file.
            model: arm model.
            body: the robot in an engine.
            felt: returns the true force of the surroundings on the hand, (3,) in [N], in the hand frame.
            ahead: time from now for whose posture the torques are computed, in [s].
            seed: seed of its errors.
        """
        self._drives = body.joints(model.joint_names)
        super().__init__(robot, model, self._drives.states()[0], seed)
        self._fastest = CATCH_UP_SPEED_RATIO * model.velocity
        self._effort = np.array([body.effort[name] for name in model.joint_names])
        self._followers = followers_of(robot.urdf_text(), model.joint_names)
        self._following = [] if body.COUPLES_MIMICS else [_Follower(body, name) for name in model.followers]
        for name, angle in zip(model.joint_names, self._command + self._offset, strict=True):
            body.reset(name, float(angle))
        for name, (leader, factor, offset) in self._followers.items():
            stands = self._command[model.joint_names.index(leader)]
            body.reset(name, factor * float(stands) + offset)
        self._felt, self._ahead = felt, ahead
        self.load: tuple[float, FloatArray] = (0.0, np.zeros(3))
        """Mass of the held object in [kg], and its middle of mass (3,) in the base frame, in [m]."""

    @override
    def true_joints(self) -> FloatArray:
        return self._drives.states()[0]

    def _true_force(self) -> FloatArray:
        return self._felt()

    def begin(self, period: int) -> None:
        """Start the control period number `period`: accept the last command, and draw the period's noise."""
        self._begin(period, loaded=self.load[0] > 0.0)

    def act(self, share: float, period: float) -> None:
        """Command the drives for the next part of a control period.

        Args:
            share: share of the period, 0 to 1, that will have passed at the end of this part.
            period: control period, in [s].
        """
        way = self._command - self._from
        angles = self._drives.states()[0]
        rate = way / period
        off = self._from + share * way + self._offset - angles
        self._drives.give(off, rate, self._effort, self._fastest, CATCHES_UP)
        soon = angles + self._ahead * rate
        torques = self._lead(soon, angles, rate) if self._following else self._model.gravity_torque(soon)
        self._drives.push(torques + self._load_torque(soon))

    def _lead(self, soon: FloatArray, angles: FloatArray, rates: FloatArray) -> FloatArray:
        """Command the followers (joints that mimic the arm's) by their own drives.

        Args:
            soon: (n,) joints for whose posture the weight is computed, in [rad] or [m].
            angles: (n,) current joints, in [rad] or [m].
            rates: (n,) rates of the joints' set-points, in [rad/s] or [m/s].

        Returns:
            (n,) efforts in [Nm] or [N] with which the arm's joints carry the weight that the followers do
            not.
        """
        torques, of_followers = self._model.own_gravity_torques(soon)
        for follower, torque in zip(self._following, of_followers, strict=True):
            leader, factor, offset = self._followers[follower.name]
            led = self._model.joint_names.index(leader)
            rate = factor * float(rates[led])
            there = factor * float(angles[led]) + offset + 2 * self._ahead * rate
            follower.joint.stand(np.array([there]), follower.most, MIMIC_STEP_RATIO, np.array([rate]))
            follower.joint.push(np.array([torque]))
        return torques

    def end(self) -> None:
        """End a control period: remember its command, from which the set-points of the next
        period move on.
        """
        self._from = self._command.copy()

    def _load_torque(self, angles: FloatArray) -> FloatArray | float:
        """Return the efforts (n,) in [Nm] or [N] that carry the held object at joints (n,) in [rad] or [m]; 0
        without one.
        """
        mass, middle = self.load
        return self._model.load_torque(angles, middle, mass) if mass > 0.0 else 0.0


class _Follower:
    """A joint that mimics another, with a drive of its own."""

    def __init__(self, body: RobotBody, name: str) -> None:
        self.name = name
        self.joint = body.joints([name])
        effort = body.effort[name]
        self.most = np.array([effort if effort > 0.0 else DEFAULT_HOLDING_EFFORT])
