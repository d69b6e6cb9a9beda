"""A simulated robot that is turned by simulated drives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.can.drives.axes import Axes
from handcart.backends.can.drives.axis import Axis
from handcart.backends.can.simulated.drive_node import DriveNode
from handcart.backends.can.simulated.plant import Plant
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.can_spec import CanSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.hand_force import efforts_of_force
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray


class BackendPlant(Plant):
    """Link between simulated drives and the robot of a simulated backend.

    It turns the drives' set-points into commands to the robot, and the robot's readings into encoder counts.
    Joints report torques (6077h) that carry the arm's weight and counteract the force that the backend reads
    at the hand. The gripper's drive reports its greatest torque while the fingers press.
    """

    def __init__(self, robot: RobotFile, spec: CanSpec, axes: Axes, inner: Backend) -> None:
        """Connect drives to a simulated robot in its initial state.

        Args:
            robot: robot file.
            spec: section `can` of that file.
            axes: the drives, as the program plans them.
            inner: simulated robot that the drives move.
        """
        self._robot, self.inner, self._axes = robot, inner, axes
        self._base = inner.get(Base)  # type: ignore[type-abstract]
        self._arm = inner.get(Arm) if self._axes.joints else None  # type: ignore[type-abstract]
        self._gripper = inner.get(Gripper) if self._axes.gripper else None  # type: ignore[type-abstract]
        self._model: ArmModel | None = robot.arm_model() if self._arm else None
        self._rated = np.array([joint.rated_effort for joint in spec.joints])
        self._driven: dict[int, float] = {}

    def place(self, drives: Mapping[int, DriveNode]) -> None:
        """Set the simulated drives, given by node ID, to the positions at which the simulated robot's arm and
        gripper are.
        """
        command = self._arm.command() if self._arm else ()
        for axis, angle in zip(self._axes.joints, command, strict=False):
            drives[axis.spec.node].stand_at(float(angle) * axis.units.scale + axis.units.zero)
        if self._axes.gripper and self._gripper:
            axis = self._axes.gripper
            drives[axis.spec.node].stand_at(self._gripper.command() * axis.units.scale + axis.units.zero)
        self._driven = {node: drive.driven for node, drive in drives.items()}
        self._tell(drives, 1.0)
        for drive in drives.values():
            drive.velocity = 0.0

    @override
    def step(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        self._roll(drives, seconds)
        if self._arm and self._changed(drives, *self._axes.joints):
            self._move_arm(self._arm, drives)
        if self._gripper and self._axes.gripper and self._changed(drives, self._axes.gripper):
            width = self._asked(drives, self._axes.gripper)
            self._gripper.move(min(max(0.0, width), self._axes.gripper.limits.upper))
        self._driven = {node: drive.driven for node, drive in drives.items()}
        self.inner.step()
        self._tell(drives, seconds)

    def _changed(self, drives: Mapping[int, DriveNode], *axes: Axis) -> bool:
        return any(drives[axis.spec.node].driven != self._driven[axis.spec.node] for axis in axes)

    def _asked(self, drives: Mapping[int, DriveNode], axis: Axis) -> float:
        return axis.units.position(drives[axis.spec.node].driven)

    def _roll(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        """Command the base by the turns of its wheels in this period.

        Args:
            drives: simulated drives by node ID.
            seconds: duration of the period, in [s].
        """
        if self._base is None:
            return
        drive = self._robot.drive
        left, right = (
            axis.units.speed(drives[axis.spec.node].driven - self._driven[axis.spec.node]) / seconds
            for axis in (self._axes.left, self._axes.right)
        )
        speed, turn = (left + right) / 2, (right - left) / drive.tread_m
        top, top_turn = drive.top_speed_m_s, np.radians(drive.top_turn_deg_s)
        # Ramps end at different times, and counts are whole numbers.
        self._base.drive(float(np.clip(speed, -top, top)), float(np.clip(turn, -top_turn, top_turn)))

    def _move_arm(self, arm: Arm, drives: Mapping[int, DriveNode]) -> None:
        held, limits = arm.command(), [axis.limits for axis in self._axes.joints]
        asked = np.array([self._asked(drives, axis) for axis in self._axes.joints])
        most = np.array([limit.speed for limit in limits]) * self.inner.period
        lower, upper = (np.array([getattr(limit, end) for limit in limits]) for end in ("lower", "upper"))
        arm.move(np.clip(np.clip(asked, held - most, held + most), lower, upper))

    def _tell(self, drives: Mapping[int, DriveNode], seconds: float) -> None:
        if self._base is not None:
            travel = self._base.wheel_travel()
            for axis, way in zip((self._axes.left, self._axes.right), travel[:2], strict=True):
                drives[axis.spec.node].moved(way * axis.units.scale, seconds, torque=0)
        if self._arm is not None and self._model is not None:
            angles = self._arm.joints()
            torques = self._torques(self._model, self._arm, angles)
            for axis, angle, torque in zip(self._axes.joints, angles, torques, strict=True):
                reading = round(1000.0 * torque * np.sign(axis.units.scale))
                drives[axis.spec.node].moved(_counts(axis, float(angle)), seconds, reading)
        fingers = self._axes.gripper
        if self._gripper is not None and fingers is not None:
            torque = -np.sign(fingers.units.scale) * fingers.limits.torque
            reading = int(torque) if self._gripper.closed_on_something() else 0
            drives[fingers.spec.node].moved(_counts(fingers, self._gripper.width()), seconds, reading)

    def _torques(self, model: ArmModel, arm: Arm, q: FloatArray) -> FloatArray:
        """Return the efforts (n,) of the joints' drives as shares of the rated ones, without unit.

        Args:
            model: model of the arm.
            arm: simulated arm, which returns the force on the hand.
            q: (n,) joints in [rad] or [m].
        """
        return np.asarray(efforts_of_force(model, q, arm.hand_force()) / self._rated)


def _counts(axis: Axis, position: float) -> float:
    return position * axis.units.scale + axis.units.zero
