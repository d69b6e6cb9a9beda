"""Yaw and lean of the base as the paper measures them: the spots of lasers on walls, read with a ruler."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.manipulation.suspension.laser_spot import Rates, SpotShift, fit_spots, spot_on_wall
from handcart.robotics.numerics.arrays import FloatArray

WALL_DISTANCE_M = 2.0  # [m] from the pointers to the walls
RULER_STEP_M = 0.001  # [m] of the ruler
POINTER_HEIGHT_M = 0.3  # [m] of the pointers; they sit on the base's axis
AHEAD, LEFT = 0.0, math.pi / 2
REST_PERIODS = 6  # periods for which the arm must be at rest before a reading


def read_spot(world_T_base: Transform, world_T_first: Transform, heading: float, scale: float) -> FloatArray:
    """Return the shift (2,) of a laser's spot on a wall to the left and up, in [m], as read with a ruler.

    Args:
        world_T_base: true pose (4, 4) of the base that carries the laser.
        world_T_first: (4, 4) world_T_base at the reference posture, in which the beam is perpendicular to the
            wall.
        heading: heading of the laser's beam in the base frame, in [rad].
        scale: graduation of the ruler, in [m]; 0: exact.
    """
    base_T_laser = transform((0.0, 0.0, POINTER_HEIGHT_M), (0.0, 0.0, heading))
    world_T_wall = world_T_first @ base_T_laser @ transform((WALL_DISTANCE_M, 0.0, 0.0)) @ _FACING
    first, now = (spot_on_wall(pose, base_T_laser, world_T_wall) for pose in (world_T_first, world_T_base))
    return now - first if scale == 0.0 else scale * (np.rint(now / scale) - np.rint(first / scale))


_FACING = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class LaserSurvey:
    """Simulated person who reads two laser spots, ahead and to the left of the base, whenever the arm is at
    rest.

    The person also counts the arm's swings from side to side.
    """

    def __init__(self, scene: Any, scale: float = RULER_STEP_M) -> None:
        """Prepare a survey in a simulated `scene`; `scale` is the graduation of the ruler, in [m]."""
        self._scene, self._scale = scene, scale
        self._command, self._stood = np.empty(0), 0
        self._first: tuple[Transform, FloatArray] | None = None
        self._last, self._swings = np.empty(0), 0
        self._ahead: list[SpotShift] = []
        self._left: list[SpotShift] = []

    def look(self, robot: Robot) -> None:
        """Read the laser's spots on the walls when the arm has come to rest, and count the arm's swings;
        called once a period.
        """
        command = robot.arm.command()
        same = np.array_equal(command, self._command)
        self._command, self._stood = command, self._stood + 1 if same else 0
        if self._stood not in (1, REST_PERIODS):
            return
        hand = robot.arm_model.forward(command)[:2, 3]
        if self._stood == 1:
            self._count(robot, hand)
        else:
            self._read(hand)

    def _count(self, robot: Robot, hand: FloatArray) -> None:
        if self._last.size and not np.array_equal(hand, self._last):
            way = float(np.linalg.norm(hand - self._last))
            self._swings += way >= robot.spec.suspension.swing_from_mm / 1e3
        self._last = hand

    def _read(self, hand: FloatArray) -> None:
        if self._first is None:
            self._first, self._swings = (self._scene.world_T_base.copy(), hand), 0
            return
        x, y = (hand - self._first[1]).tolist()
        for heading, shifts in ((AHEAD, self._ahead), (LEFT, self._left)):
            spot = read_spot(self._scene.world_T_base, self._first[0], heading, self._scale)
            shifts.append(SpotShift((x, y), float(self._swings), *spot.tolist()))

    def rates(self) -> Rates:
        """Return how the base tilts and yaws when the arm moves, fitted to the shifts of laser spots.

        Tilts are per metre of the hand's horizontal motion, yaw is per move of the arm out and back.

        Raises:
            ValueError: the arm moved too little.
        """
        return fit_spots(self._ahead, self._left, WALL_DISTANCE_M)

    def figures(self) -> dict[str, float]:
        """Return by how much the base rolls, pitches and yaws when the arm moves, by name with unit, as
        metrics of a run.
        """
        rates = self.rates()
        return {
            "laser_yaw_mrad_per_swing": round(1e3 * rates.yaw_per_swing, 4),
            "laser_roll_mrad_per_m": round(1e3 * rates.roll_per_m, 3),
            "laser_pitch_mrad_per_m": round(1e3 * rates.pitch_per_m, 3),
        }
