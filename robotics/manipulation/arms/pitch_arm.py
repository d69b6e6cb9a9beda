"""An arm that turns around a vertical axis, bends in the plane through it, and has no wrist yaw."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.numerics.arrays import FloatArray

from .pitch_arm_table import pitch_arm_joints, pitch_arm_table
from .placement_scores import PlacementScores
from .score_rule import ScoreRule

_FREE = (-np.inf, np.inf)


class PitchArm(NamedTuple):
    """Arm with a yaw joint, three pitch joints and a roll joint around the tool, as in Shin (2005).

    Its inverse kinematics is computed in closed form, with the elbow up. The arm puts the tool's tip on a
    path and tilts the tool by the path's elevation. The tool's azimuth follows from the base's position and
    may differ from the path's by a tolerance. The roll joint only turns the tool about its own axis, so the
    limits of a `ScoreRule` are those of the other four joints. Joint angles are 0 if the arm is stretched out
    level and ahead, and positive upwards and to the left.
    """

    ahead: float = 0.35
    """Distance of the yaw axis ahead of the base's centre, in [m]."""
    height: float = 0.80
    """Height of the shoulder above the floor, in [m]."""
    links: tuple[float, float, float] = (0.55, 0.55, 0.25)
    """Lengths of upper arm, forearm, and wrist to tool tip, in [m]."""
    yaw_limit: float = np.radians(150.0)
    """Largest yaw to either side, in [rad]."""
    azimuth_tolerance: float = np.radians(60.0)
    """Largest difference between the azimuths of tool and path, in [rad]."""
    pitch_limits: tuple[tuple[float, float], tuple[float, float], tuple[float, float]] = (_FREE, _FREE, _FREE)
    """Lowest and highest angles of the pitch joints, in [rad]."""

    def scores(self, bases: FloatArray, path: ToolPath, rule: ScoreRule) -> PlacementScores:
        """Return how well the arm can work at each point of a path from each base pose, as scores.

        Args:
            bases: (b, 3) world_T_base on the floor: x, y in [m], heading in [rad].
            path: path of the tool in the world.
            rule: rule for the score: its measure, and limits on the lever of the tool's force.
        """
        values, usable = pitch_arm_table(
            self._stands(bases), self.marks(path), self._figures(), int(rule.measure), rule.limits
        )
        return PlacementScores(values.T, usable.T)

    def joints(self, base: FloatArray, path: ToolPath) -> FloatArray:
        """Return the yaw and pitch angles that hold the tool at a path's points.

        Args:
            base: (3,) world_T_base on the floor: x, y in [m], heading in [rad].
            path: path of the tool in the world.

        Returns:
            (p, 4) in [rad]: yaw, then the pitch joints from the shoulder on; NaN out of reach.
        """
        return pitch_arm_joints(self._stands(np.atleast_2d(base))[0], self.marks(path), self._figures())

    def shoulders(self, bases: FloatArray) -> FloatArray:
        """Return the positions of the arm's vertical yaw axis in the world.

        Args:
            bases: (b, 3) world_T_base: x, y in [m], heading in [rad].

        Returns:
            (b, 2) x and y of the axis for each base pose, in [m].
        """
        return self._stands(bases)[:, :2]

    def _stands(self, bases: FloatArray) -> FloatArray:
        """(b, 4): shoulder x, y and the heading's cosine and sine."""
        cos, sin = np.cos(bases[:, 2]), np.sin(bases[:, 2])
        return np.column_stack((bases[:, 0] + self.ahead * cos, bases[:, 1] + self.ahead * sin, cos, sin))

    def marks(self, path: ToolPath) -> FloatArray:
        """Return one row for each point of a path, (p, 11), as input of the compiled computation of scores
        and joints.

        A row holds the position (3) in [m] and the tangent (3), both in the world; the unit vector (2) along
        the level part of the tool's x axis; and the cosine, the sine and the rate, in [rad/m], of that axis'
        elevation.
        """
        axes = path.rotations[:, :, 0]
        level = np.hypot(axes[:, 0], axes[:, 1])
        safe = np.maximum(level, np.finfo(float).tiny)
        rate = np.cross(path.turns, axes)[:, 2] / np.maximum(level, _STEEP)
        return np.column_stack(
            (path.points, path.tangents, axes[:, :2] / safe[:, None], level, axes[:, 2], rate)
        )

    def _figures(self) -> FloatArray:
        turns = (np.cos(self.yaw_limit), np.cos(self.azimuth_tolerance))
        return np.array((self.height, *self.links, *turns, *np.ravel(self.pitch_limits)))


_STEEP = 1e-6
