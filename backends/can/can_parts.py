"""Capabilities of a robot with CAN drives."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from handcart.backends.can.drives.axes import Axes
from handcart.backends.capabilities.arm import Arm, ForceArm
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.can_spec import CanSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.numerics.arrays import FloatArray

from .can_arm import CanArm, CanForceArm, kind_of_arm
from .can_base import CanBase
from .can_gripper import CanGripper


class CanParts:
    """Base, arm and gripper of a robot with CAN drives, and the commands to them."""

    def __init__(self, robot: RobotFile, spec: CanSpec, axes: Axes) -> None:
        """Build the capabilities that a robot's file declares."""
        self.base = CanBase(robot.drive, axes.left, axes.right)
        self.arm: CanArm | None = None
        """The arm; None for a robot without one."""
        self.gripper: CanGripper | None = None
        """The gripper; None for a robot without one."""
        if axes.joints:
            rated = np.array([joint.rated_effort for joint in spec.joints])
            self.arm = kind_of_arm(spec.joints)(robot.arm_model(), axes.joints, rated, robot.period_s)
        if axes.gripper is not None and robot.gripper is not None:
            self.gripper = CanGripper(robot.gripper, axes.gripper)

    def capabilities(self) -> tuple[Capability, ...]:
        """Return the interfaces (`Capability`) by which base, arm and gripper are commanded, as far as the
        robot has them.
        """
        return tuple(item for item in (self.base, self.arm, self.gripper) if item is not None)

    def begin(self) -> None:
        """Set the measured positions of arm and gripper as set-points, before the drives are enabled."""
        for item in (self.arm, self.gripper):
            if item is not None:
                item.begin()

    STATE: ClassVar = {
        "travel": WheelTravel,
        "joints": FloatArray | None,
        "opening": float | None,
    }
    """Attributes that a checkpoint keeps, with their types."""

    @property
    def travel(self) -> WheelTravel:
        """Travel of the wheels by their encoders, in [m]."""
        return self.base.wheel_travel()

    @travel.setter
    def travel(self, rolled: WheelTravel) -> None:
        self.base.set_travel(rolled)

    @property
    def joints(self) -> FloatArray | None:
        """Last commanded positions (n,) of the arm's joints, in [rad] or [m]; None without an arm."""
        return None if self.arm is None else self.arm.command()

    @joints.setter
    def joints(self, commanded: FloatArray | None) -> None:
        if self.arm is not None and commanded is not None:
            self.arm.holds(commanded)

    @property
    def opening(self) -> float | None:
        """Last commanded opening of the gripper, in [m]; None without a gripper."""
        return None if self.gripper is None else self.gripper.command()

    @opening.setter
    def opening(self, commanded: float | None) -> None:
        if self.gripper is not None and commanded is not None:
            self.gripper.holds(commanded)

    def pass_on(self) -> None:
        """Pass the commands of this control period for base, arm and gripper on to their drives."""
        self.base.pass_on()
        for item in (self.arm, self.gripper):
            if item is not None:
                item.pass_on()

    def halt(self) -> None:
        """Discard the command of the base, so that the base stops, and make arm and gripper hold."""
        self.base.forget()
        for item in (self.arm, self.gripper):
            if item is not None:
                item.halt()


def capabilities_of(robot: RobotFile) -> tuple[type[Capability], ...]:
    """Return the kinds of capability, such as arm or lidar, that a robot has by the section `can` of its
    file.

    The section lists the robot's drives and sensors.
    """
    spec = robot.can
    if spec is None:
        return ()
    sensors = spec.sensors
    there: dict[type[Capability], object] = {
        Base: spec.left,
        ForceArm if kind_of_arm(spec.joints) is CanForceArm else Arm: spec.joints,
        Gripper: spec.gripper,
        Camera: sensors.camera if robot.hand_camera is not None else None,
        RangeSensor: sensors.range_sensor,
        Imu: sensors.imu,
        Gps: sensors.gps,
    }
    return tuple(kind for kind, what in there.items() if what)
