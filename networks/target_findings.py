"""Whether the robot can stand where it has to for its targets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from handcart.backends.robot_file import RobotFile
from handcart.files.errors import Finding
from handcart.primitives.field import Field
from handcart.primitives.target import Target


def target_findings(
    targets: Mapping[str, Target], field: Field, robot: RobotFile, file: Path
) -> Iterator[Finding]:
    """Targets that can't be reached: what is known to stand in the field is too near to them."""
    room = robot.footprint_radius_m
    for target in targets.values():
        for x, y, radius in field.discs.tolist():
            near = math.hypot(target.stand.x - x, target.stand.y - y) - radius
            if near < room or math.hypot(target.x - x, target.y - y) < radius:
                told = f"the target {target.name!r} can't be reached: the rock at ({x:g}, {y:g}) m leaves"
                room_left = f"{max(near, 0.0):.2f} m for the base beside it; allowed: {room:g} m at least"
                yield Finding(str(file), target.line, target.column, f"{told} {room_left}")
