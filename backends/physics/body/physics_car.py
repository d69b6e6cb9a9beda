"""The wheels of a simulated robot that steers like a car."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.engine.surface import SOFT_TYRES
from handcart.backends.physics.urdf.sound_urdf import ROCKER_JOINTS
from handcart.backends.simulation.body.simulated_parts import CommandedBase
from handcart.robotics.geometry.transform import inverse

from .robot_body import RobotBody
from .wheel_drives import WheelDrives

REAR, FRONT = ("left_wheel", "right_wheel"), ("front_left_wheel", "front_right_wheel")
STEERING_JOINTS = ("left_steering", "right_steering")
"""Steering joints of the URDF; the rear wheels define the base's frame."""
STEERING_TIME_S = 0.05  # time constant of the steering [s]


class PhysicsCar(CommandedBase):
    """Car in a physics engine; four driven wheels roll and slip, and the front wheels steer (Ackermann)."""

    STATE: ClassVar = {**CommandedBase.STATE, "_bend": float}

    def __init__(self, robot: RobotFile, body: RobotBody, chunk: float, ground: GroundSpec) -> None:
        """Take wheels and steering over.

        Args:
            robot: robot file.
            body: the robot in an engine.
            chunk: time between two actions of the drives, in [s].
            ground: the ground's roughness and softness.
        """
        super().__init__(robot)
        wheels = (*REAR, *FRONT)
        self._steering = body.joints(STEERING_JOINTS)
        self._turns = np.array([body.effort[name] for name in STEERING_JOINTS])
        base = inverse(body.base_pose())
        self._ahead, self._left = np.array([(base @ body.link_pose(name))[:2, 3] for name in wheels]).T
        self.drives = WheelDrives(body, chunk, wheels)
        body.cover(wheels, SOFT_TYRES._replace(sinks=ground.softness_mm_per_100n / 1e5))
        if set(ROCKER_JOINTS) <= set(body.effort):
            body.mirror(ROCKER_JOINTS)
        self._bend = 0.0

    def begin(self, period: int) -> None:
        """Start the motion of the control period number `period`, by the car's last command."""
        speed, turn_rate, _ = self._take_command()
        if speed != 0.0:
            most = self._drive.steering_per_m_s * self._period
            self._bend += max(-most, min(most, turn_rate / speed - self._bend))
        rims = speed * np.hypot(1.0 - self._bend * self._left, self._bend * self._ahead)
        self.drives.speeds = rims / self._drive.wheel_radius_m

    def give(self, turn: float) -> None:
        """Do nothing, because a car's tyres do not yield when its arm swings; `turn` [rad] is ignored."""

    def act(self) -> None:
        """Command the drives of wheels and steering for the next part of the control period."""
        self.drives.follow()
        wanted = [
            math.atan2(self._bend * ahead, 1.0 - self._bend * left)
            for ahead, left in zip(self._ahead[2:], self._left[2:], strict=True)
        ]
        off = np.array(wanted) - self._steering.states()[0]
        self._steering.follow(off, np.zeros(len(off)), self._turns, STEERING_TIME_S)

    def read(self) -> None:
        """Update the wheels' travel from the encoders of the rear wheels, at the end of a period."""
        left, right = self.drives.turned()[:2] * self._drive.wheel_radius_m
        self._travel = WheelTravel(float(left), float(right))

    def rezero(self) -> None:
        """Restart the wheels' travel at 0 from their present angles."""
        self.drives.rezero()
        self.read()
