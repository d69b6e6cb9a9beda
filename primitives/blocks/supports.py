"""Supports of a block by the building plan."""

from __future__ import annotations

from collections.abc import Sequence

from handcart.primitives.blocks.building import name_of_block
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.robotics.geometry.pose2 import Pose2

from .building import Building

SUPPORT_TOLERANCE_M = 0.005  # that a support's top may be off the foot of what it carries
TRAY_NAME = "tray"


def held_on(plan: Building, foot: LevelPose, among: Sequence[LevelPose]) -> tuple[MeantContact, ...]:
    """Return the intended contacts of a held block with the tables and blocks that support it at a goal.

    Args:
        plan: building plan with the tables.
        foot: goal of the block, on the map.
        among: poses of the other blocks, in the order of their numbers, on the map.
    """
    length, width, height = plan.block
    blocks = [
        name_of_block(number)
        for number, pose in enumerate(among, start=1)
        if abs(pose.height_m + height - foot.height_m) < SUPPORT_TOLERANCE_M
        and _below(foot.floor, pose.floor, (2 * length, 2 * width))
    ]
    tables = [
        name
        for name, table in plan.tables.items()
        if abs(table.height_m - foot.height_m) < SUPPORT_TOLERANCE_M
        and _below(foot.floor, table.floor, (table.size_m[0] + length, table.size_m[1] + width))
    ]
    # A table of the plan may be a block of the world: a stone that the wall begins at.
    stones = [f"block {name}" for name in tables]
    return tuple(MeantContact("held", name) for name in (*tables, *stones, *blocks))


def _below(foot: Pose2, middle: Pose2, size: tuple[float, float]) -> bool:
    """Return whether a foot is within a rectangle of `size` around `middle`."""
    off = foot.relative_to(middle)
    return abs(off.x) < size[0] / 2 and abs(off.y) < size[1] / 2
