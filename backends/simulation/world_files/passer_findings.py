"""What is wrong between passers, the solids of their world, and the robot's start."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from handcart.backends.simulation.passers.passers import BODY_HEIGHT_M, Passers
from handcart.backends.simulation.world.solids import MIN_BODY_HEIGHT_M, FloorPlan, Solid
from handcart.robotics.geometry.pose2 import Pose2

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.backends.simulation.passers.passer_spec import PasserSpec
    from handcart.backends.simulation.world.world_file import WorldFile
    from handcart.files.errors import Finding
    from handcart.files.models.loading import Loaded

WALK_SPACING_M = 0.05  # between the points of a walk that are held against solids
SQUEEZE_M = 0.1  # by which a body may come nearer to a solid than its radius: shoulders turn


def passer_findings(
    loaded: Loaded[WorldFile], robot: RobotFile, solids: Sequence[Solid]
) -> Iterator[Finding]:
    """Yield findings on passers who walk through something solid, or begin where the robot starts.

    Args:
        loaded: the world's file, with line and column of each value.
        robot: robot that starts in this world.
        solids: all solids of the world; those that appear or disappear during a run are not checked.
    """
    world = loaded.value
    if not world.passers:
        return
    lasting = [solid for solid in solids if solid.appears == 0.0 and math.isinf(solid.leaves)]
    plan = FloorPlan(lasting, MIN_BODY_HEIGHT_M, BODY_HEIGHT_M)
    for number, spec in enumerate(world.passers):
        yield from _walks_through(loaded, number, spec, plan)
    start = world.start
    base = Pose2(start.x_m, start.y_m, math.radians(start.heading_deg))
    gap, name = Passers(world.passers).gap(base, robot.footprint_shape)
    if gap < 0.0:
        where = f"passer {name} stands where the robot starts: {-gap:.2f} m inside its footprint"
        yield loaded.finding(("start",), f"{where}; allowed: beyond its footprint")


def _walks_through(
    loaded: Loaded[WorldFile], number: int, spec: PasserSpec, plan: FloorPlan
) -> Iterator[Finding]:
    around = [*spec.waypoints_m, *(spec.waypoints_m[:1] if spec.at_end == "loop" else ())]
    pairs = list(pairwise(around)) or [(around[0], around[0])]
    for index, (begin, end) in enumerate(pairs):
        count = max(2, math.ceil(math.dist(begin, end) / WALK_SPACING_M) + 1)
        for x, y in np.linspace(begin, end, count).tolist():
            away, name = plan.clearance(x, y, 0.0)
            if away < spec.radius_m - SQUEEZE_M:
                key = ("passers", number, "waypoints_m", index)
                wrong = f"{spec.name} walks through {name} at ({x:.2f}, {y:.2f}) m on the way from this point"
                allowed = f"allowed: {spec.radius_m - SQUEEZE_M:.2f} m at least from what is solid"
                yield loaded.finding(key, f"{wrong}; {allowed}")
                break
