"""Any arm of a URDF, scored over base placements."""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray

from .placement_scores import PlacementScores
from .score_rule import Measure, ScoreRule
from .screw_chain import ScrewChain
from .screw_steps import NOTHING_FREE, TOOL_FREE, VERTICAL_FREE
from .screw_table import StartPool, ToolRule, ToolTargets, pool_poses, screw_table


class FreeTurn(IntEnum):
    """Turn of the tool that a path does not prescribe, so that the arm may choose it: none, the turn about
    the vertical, or the turn about the tool's own axis.
    """

    NONE = NOTHING_FREE
    VERTICAL = VERTICAL_FREE
    """Azimuth, within a tolerance: used for arms without wrist yaw."""
    TOOL = TOOL_FREE
    """Turn around the tool's own x axis: used for round tools."""


class ScrewArm:
    """Numerical inverse kinematics of an arm with revolute joints, for scores of a path's points from base
    poses.

    The iteration for a point starts at the joints for the point before it. Reachability is found by trial: a
    reachable point may be reported as out of reach, but not the other way round. Top speeds along the path
    are exact for arms with as many joints as the tool's prescribed coordinates, or one more. With more
    redundant joints, the speed for the least joint motion is used, which is lower.

    Args:
        arm: the arm; all its joints turn, and its base link is upright.
        free: turn of the tool that the path leaves free.
        azimuth_tolerance: allowed turn of the tool about the vertical with FreeTurn.VERTICAL, in [rad].
        postures: number of random postures from which iterations start.

    Raises:
        ValueError: a joint slides.
    """

    def __init__(
        self,
        arm: ArmModel,
        free: FreeTurn = FreeTurn.NONE,
        azimuth_tolerance: float = np.pi,
        postures: int = 512,
        seed: int = 0,
    ) -> None:
        self.chain = ScrewChain.of_arm(arm)
        self.free = free
        self.azimuth_tolerance = azimuth_tolerance
        rng = np.random.default_rng(seed)
        self._pool = rng.uniform(arm.lower, arm.upper, (postures, arm.dof))

    @cached_property
    def _poses(self) -> FloatArray:
        """base_T_tip (m, 4, 4) of the postures that descents start from."""
        return pool_poses(self.chain, self._pool)

    def scores(self, bases: FloatArray, path: ToolPath, rule: ScoreRule) -> PlacementScores:
        """Return how well the arm can work at each point of a path from each base pose, as scores.

        Args:
            bases: (b, 3) world_T_base on the floor: x, y in [m], heading in [rad].
            path: path of the tool in the world.
            rule: rule for the score: its measure, and the limits of the joints.
        """
        values, usable, joined = self._table(bases, path, rule, np.empty((0, 0, 0)))
        return PlacementScores(values.T, usable.T, joined.T)

    def joints(self, base: FloatArray, path: ToolPath, rule: ScoreRule | None = None) -> FloatArray:
        """Return the joint angles that hold the tool at a path's points.

        Args:
            base: (3,) world_T_base on the floor: x, y in [m], heading in [rad].
            path: path of the tool in the world.
            rule: rule for the score: its measure, and the limits of the joints; None: reachability alone.

        Returns:
            (p, n) in [rad]; NaN for a point that the arm cannot reach, or not within the limits of the rule.
        """
        rule = rule or ScoreRule.uniform(Measure.REACHABILITY, 0.1, 1.0, self.chain.dof)
        angles = np.full((1, len(path.points), self.chain.dof), np.nan)
        self._table(np.atleast_2d(base), path, rule, angles)
        joints: FloatArray = angles[0]
        return joints

    def _table(
        self, bases: FloatArray, path: ToolPath, rule: ScoreRule, angles: FloatArray
    ) -> tuple[SingleArray, BoolArray, BoolArray]:
        headings = bases[:, 2]
        return screw_table(
            self.chain,
            StartPool(self._pool, self._poses),
            np.column_stack((bases[:, :2], np.cos(headings), np.sin(headings))),
            ToolTargets(path.poses, path.twists),
            ToolRule(
                int(self.free),
                float(np.cos(self.azimuth_tolerance)),
                self.chain.reach,
                int(rule.measure),
                rule.limits,
            ),
            angles,
        )
