"""The wheels of the simulated robot."""

from __future__ import annotations

import math

import numpy as np

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import RobotFile
from backends.scene.keyed_noise import keyed

from .physics import Physics
from .robot_body import WHEEL_FRICTION, RobotBody

COUNTS = 65536  # of an encoder, a turn
CATCHES_UP = 0.02  # time constant of the drives' position loop [s]
MOST_LAG = 0.05  # that a blocked wheel makes up for later [rad]


class BulletBase(Base):
    """Wheels with velocity drives on a floor that they roll on, and slip on; those of a side turn together.

    The file's errors of radius and tread are put onto the speeds, as if the wheels and where they stand were
    not quite as the file has them; slip is the engine's. Encoders count whole steps. That tyres give is
    imposed (`give`): the engine's are rigid.
    """

    def __init__(self, robot: RobotFile, body: RobotBody, physics: Physics, seed: int) -> None:
        """Take the driven wheels over; other links must slide on the floor."""
        self._drive, self._body, self._physics = robot.drive, body, physics
        errors = robot.errors
        left, right, tread = keyed(seed, "wheels").standard_normal(3)
        wheels = body.wheels
        self._lefts = len(wheels.left)
        self._right = np.repeat([False, True], [len(wheels.left), len(wheels.right)])
        """(n,): which of the wheels are on the right side."""
        self._scale = 1.0 + errors.wheel_radius_percent / 100 * np.where(self._right, right, left)
        self._tread_scale = 1.0 + errors.tread_percent / 100 * float(tread)
        self._joints = [body.joint_index[name] for name in wheels.all]
        self._force = [body.effort[name] / physics.substeps for name in wheels.all]
        body.rub(wheels.all, WHEEL_FRICTION)
        if len(self._joints) > 2:
            body.scrub(wheels.all)
        self._command = (0.0, 0.0)
        self._speeds = np.zeros(len(self._joints))
        self._first = self._goal = body.states(self._joints)[0]
        self._given = np.zeros(len(self._joints))
        """By how much the wheels' rims have moved on the floor that no encoder saw, as angles, in [rad]."""
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
        half = turn_rate / self._tread_scale * self._drive.tread_m / 2
        rims = np.where(self._right, speed + half, speed - half)
        self._speeds = rims * self._scale / self._drive.wheel_radius_m

    def give(self, turn: float) -> None:
        """Turn the standing base by an angle in [rad] on its tyres: no encoder sees it."""
        rim = turn * self._drive.tread_m / 2 / self._drive.wheel_radius_m
        rolled = np.where(self._right, rim, -rim)
        self._given = self._given + rolled
        self._goal = self._goal + rolled

    def act(self) -> None:
        """Command the drives for the next chunk of the period; they follow the angle, not only the speed."""
        p, seconds = self._physics.p, self._physics.chunk
        angles = self._body.states(self._joints)[0]
        lag = np.minimum(np.maximum(self._goal - angles, -MOST_LAG), MOST_LAG)
        wanted = self._speeds + lag / CATCHES_UP
        self._goal = angles + lag + self._speeds * seconds
        p.setJointMotorControlArray(
            self._body.id,
            self._joints,
            p.VELOCITY_CONTROL,
            targetVelocities=wanted.tolist(),
            forces=self._force,
            physicsClientId=self._physics.client,
        )

    def read(self) -> None:
        """Take the encoders' readings at the end of a period."""
        turned = (self._body.states(self._joints)[0] - self._given - self._first) / self._scale
        counts = np.round(turned * (COUNTS / (2 * math.pi)))
        travel = counts * (2 * math.pi / COUNTS * self._drive.wheel_radius_m)
        lefts, wheels = self._lefts, len(travel)
        left, right = sum(travel[:lefts]) / lefts, sum(travel[lefts:]) / (wheels - lefts)
        self._travel = WheelTravel(float(left), float(right))

    def rezero(self) -> None:
        """Count from here on."""
        self._first = self._body.states(self._joints)[0] - self._given
        self.read()
