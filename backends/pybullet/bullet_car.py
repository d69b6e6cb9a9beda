"""The wheels of a simulated robot that steers like a car."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import RobotFile
from robotics.geometry.transform import inverse

from .physics import Physics
from .robot_body import WHEEL_FRICTION, RobotBody

REAR, FRONT = ("left_wheel", "right_wheel"), ("front_left_wheel", "front_right_wheel")
STEERING = ("left_steering", "right_steering")
"""Joints of the URDF: the rear wheels' stand for the base's frame."""
COUNTS = 65536  # of an encoder, a turn
CATCHES_UP = 0.02  # time constant of the drives' position loop [s]
MOST_LAG = 0.05  # that a blocked wheel makes up for later [rad]
STEERS = 0.05  # time constant of the steering [s]
TYRE_STIFFNESS, TYRE_DAMPING = 3e5, 6e3  # of a wheel on the ground, in [N/m] and [Ns/m]


class BulletCar(Base):
    """Four driven wheels on ground that they roll on and slip on; those in front steer (Ackermann).

    The wheels' speeds are those of a body that doesn't slip. Wheel travel is that of the rear wheels. Slip is
    the engine's.
    """

    STATE: ClassVar = ("_command", "_speeds", "_bend", "_goal", "_first", "_travel")

    def __init__(self, robot: RobotFile, body: RobotBody, physics: Physics) -> None:
        """Take wheels and steering over."""
        self._drive, self._body, self._physics = robot.drive, body, physics
        self._period = robot.period_s
        wheels = (*REAR, *FRONT)
        self._wheels = [body.joint_index[name] for name in wheels]
        self._steering = [body.joint_index[name] for name in STEERING]
        self._force = [body.effort[name] / physics.substeps for name in wheels]
        self._turns = [body.effort[name] / physics.substeps for name in STEERING]
        base = inverse(body.base_pose())
        self._ahead, self._left = np.array([(base @ body.link_pose(name))[:2, 3] for name in wheels]).T
        body.rub(wheels, WHEEL_FRICTION)
        for name in wheels:
            physics.p.changeDynamics(
                body.id,
                body.link_index[name],
                contactStiffness=TYRE_STIFFNESS,
                contactDamping=TYRE_DAMPING,
                frictionAnchor=1,  # at rest it sticks
                physicsClientId=physics.client,
            )
        self._command, self._bend = (0.0, 0.0), 0.0
        self._speeds = np.zeros(4)
        self._first = self._goal = body.states(self._wheels)[0]
        self._travel = WheelTravel(0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        self._command = checked_drive(self._drive, speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return self._travel

    def halt(self) -> None:
        """Forget the command."""
        self._command = (0.0, 0.0)

    def begin(self) -> None:
        """A period begins: the command counts for it, and only for it."""
        (speed, turn_rate), self._command = self._command, (0.0, 0.0)
        if speed != 0.0:
            most = self._drive.steering_per_m_s * self._period
            self._bend += max(-most, min(most, turn_rate / speed - self._bend))
        rims = speed * np.hypot(1.0 - self._bend * self._left, self._bend * self._ahead)
        self._speeds = rims / self._drive.wheel_radius_m

    def give(self, turn: float) -> None:
        """A car's wheels give nothing to a swing of its arm."""

    def act(self) -> None:
        """Command the drives for the next chunk of the period."""
        p, seconds, client = self._physics.p, self._physics.chunk, self._physics.client
        angles = self._body.states(self._wheels)[0]
        lag = np.clip(self._goal - angles, -MOST_LAG, MOST_LAG)
        self._goal = angles + lag + self._speeds * seconds
        p.setJointMotorControlArray(
            self._body.id,
            self._wheels,
            p.VELOCITY_CONTROL,
            targetVelocities=(self._speeds + lag / CATCHES_UP).tolist(),
            forces=self._force,
            physicsClientId=client,
        )
        wanted = [
            math.atan2(self._bend * ahead, 1.0 - self._bend * left)
            for ahead, left in zip(self._ahead[2:], self._left[2:], strict=True)
        ]
        off = np.array(wanted) - self._body.states(self._steering)[0]
        p.setJointMotorControlArray(
            self._body.id,
            self._steering,
            p.VELOCITY_CONTROL,
            targetVelocities=(off / STEERS).tolist(),
            forces=self._turns,
            physicsClientId=client,
        )

    def read(self) -> None:
        """Take the encoders' readings at the end of a period."""
        turned = (self._body.states(self._wheels)[0] - self._first)[:2]
        counts = np.round(turned * (COUNTS / (2 * math.pi)))
        left, right = counts * (2 * math.pi / COUNTS * self._drive.wheel_radius_m)
        self._travel = WheelTravel(float(left), float(right))

    def rezero(self) -> None:
        """Count from here on."""
        self._first = self._body.states(self._wheels)[0]
        self.read()
