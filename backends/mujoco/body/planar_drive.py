"""A drive that pushes the base of a robot in MuJoCo."""

from __future__ import annotations

from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.physics.body.robot_body import PlanarDrive
from handcart.robotics.numerics.arrays import FloatArray

SITE_NAME = "planar drive"
DRIVE_AXES = ("ahead", "left", "turn")
AXIS_GEARS = ((1, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (0, 0, 0, 0, 0, 1))
CATCHES_UP_S = 0.005
"""Time constant with which the base reaches a commanded speed, within the limits of the drive."""


class MujocoPlanarDrive(PlanarDrive):
    """Drive without wheels, in which three velocity servos of MuJoCo push the base in the plane.

    The servos act ahead, to the left, and about the vertical axis.
    """

    def __init__(self, engine: MujocoEngine, mass: float, inertia: float, prefix: str) -> None:
        """Drive a base that has the servos of `add_planar_drive`.

        Args:
            engine: engine with the robot.
            mass: mass of the robot, in [kg].
            inertia: moment of inertia of the robot about the vertical, in [kg m²].
            prefix: prefix of the names of the robot's joints and servos.
        """
        self._engine = engine
        self._numbers = [int(engine.model.actuator(prefix + _name(axis)).id) for axis in DRIVE_AXES]
        self._gain = np.array([mass, mass, inertia]) / CATCHES_UP_S

    @override
    def limit(self, force: float, torque: float) -> None:
        limits = self._engine.model.actuator_forcerange
        limits[self._numbers, 1] = (force, force, torque)
        limits[self._numbers, 0] = -limits[self._numbers, 1]

    @override
    def drive(self, twist: FloatArray) -> None:
        model = self._engine.model
        model.actuator_gainprm[self._numbers, 0] = self._gain
        model.actuator_biasprm[self._numbers, 2] = -self._gain
        self._engine.data.ctrl[self._numbers] = twist


def add_planar_drive(robot: Any) -> None:
    """Add the three servos of `MujocoPlanarDrive` to the `MjSpec` of a robot, with zero gain."""
    robot.body("base").add_site(name=SITE_NAME)
    for axis, gear in zip(DRIVE_AXES, AXIS_GEARS, strict=True):
        servo = robot.add_actuator(name=_name(axis), target=SITE_NAME)
        servo.trntype = mujoco().mjtTrn.mjTRN_SITE
        servo.biastype = mujoco().mjtBias.mjBIAS_AFFINE
        servo.gear = gear
        servo.forcelimited, servo.forcerange = 1, (-1e-9, 1e-9)


def _name(axis: str) -> str:
    return f"{SITE_NAME} {axis}"
