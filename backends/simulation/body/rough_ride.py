"""Motion of a car over rough ground."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.robotics.far import Far
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_CURVATURE
from handcart.robotics.numerics.arrays import FloatArray

SETS_OUT = 1.0  # [s] of standing after which the ground under a curve is another


class RoughRide:
    """Simulated motion of a car on rough ground, with random tilt and slip.

    Roll, pitch, and slip along and across the heading are Ornstein-Uhlenbeck processes over the driven
    distance, as in `benchmarks.field.field_drive`. `tilt` is roll and pitch in [rad].
    """

    STATE: ClassVar = {
        "tilt": tuple[float, float],
        "_waves": FloatArray,
        "_slip": float,
        "_side": float,
        "_turn_slip": float,
        "_stood": Far,
        "_legs": int,
    }

    def __init__(self, robot: RobotFile, ground: GroundSpec, seed: int) -> None:
        """Prepare rides on a ground.

        Args:
            robot: robot file; if its `errors` has none, the robot tilts but does not slip.
            ground: sigmas of the ground, from the world's file.
            seed: seed of tilt and slip.
        """
        self._seed, self._period, self._ground = seed, robot.period_s, ground
        self._errs = 0.0 if robot.errors.none else 1.0
        scale, *waves = keyed(seed, "ground").standard_normal(5).tolist()
        self._scale = self._errs * ground.scale_percent / 100 * scale
        self._rough = math.radians(ground.roughness_deg)
        self._waves: FloatArray = math.sqrt(2.0) * self._rough * np.array(waves[:2])
        self.tilt = (float(self._waves[0]) / 2.0, float(self._waves[1]) / 2.0)
        self._slip = self._errs * ground.slip_percent / 100 * waves[2]
        self._side = self._errs * math.radians(ground.side_slip_deg) * waves[3]
        self._turn_slip, self._stood, self._legs = 0.0, math.inf, 0

    def motion(self, rolled: float, bend: float, period: int) -> Pose2:
        """Return the base's pose at the end of a period, in the base frame at its start, ignoring obstacles.

        Args:
            rolled: the wheels' travel, in [m].
            bend: steered curvature, in [1/m], positive to the left.
            period: number of the period.
        """
        if rolled == 0.0:
            self._stood += self._period
            return Pose2(0.0, 0.0, 0.0)
        if self._stood >= SETS_OUT:
            self._legs += 1
            share = self._errs * self._ground.turn_slip_percent / 100
            self._turn_slip = share * float(keyed(self._seed, "turn slip", self._legs).standard_normal())
        self._stood = 0.0
        slipping = self._scale + self._slip + self._turn_slip * abs(bend) / REFERENCE_CURVATURE
        way = rolled / max(0.2, 1.0 + slipping)
        self._change(abs(way), period)
        beside = self._side + self._errs * math.radians(self._ground.side_slip_deg_m) * bend
        course, level = 0.5 * way * bend + beside, way * math.cos(self.tilt[1])
        return Pose2(level * math.cos(course), level * math.sin(course), way * bend)

    def _change(self, way: float, period: int) -> None:
        """Advance by `way` [m] on the ground."""
        draws, ground = keyed_normal(self._seed, "ground", period, 4), self._ground
        share = way / ground.roughness_length_m
        keep, new = _drift(share, math.sqrt(2.0) * self._rough)
        self._waves = keep * self._waves + new * draws[:2]
        near = 1.0 - math.exp(-share)
        roll, pitch = (
            angle + near * (float(wave) - angle) for angle, wave in zip(self.tilt, self._waves, strict=True)
        )
        self.tilt = (roll, pitch)
        slip, side = self._errs * ground.slip_percent / 100, self._errs * math.radians(ground.side_slip_deg)
        keep, new = _drift(way / ground.slip_length_m, slip)
        self._slip = keep * self._slip + new * float(draws[2])
        keep, new = _drift(way / ground.side_slip_length_m, side)
        self._side = keep * self._side + new * float(draws[3])


def _drift(share: float, sigma: float) -> tuple[float, float]:
    """Return the kept share of an Ornstein-Uhlenbeck value, and the sigma of its new part.

    Args:
        share: distance driven, divided by the correlation length.
        sigma: sigma of the value.
    """
    keep = math.exp(-share)
    return keep, sigma * math.sqrt(1.0 - keep * keep)
