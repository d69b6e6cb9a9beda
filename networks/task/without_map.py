"""Tasks without a map (`map: none`): places are relative to the start, and only what is sensed is avoided."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.files.yaml.yaml_document import Document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

NO_MAP = "none"
"""Value of `map` under `knowledge:`."""
MAP_KEY = ("knowledge", "map")
MARGIN_M = 8.0
"""Width of the floor beyond the outermost place, needed by routes around sensed obstacles."""
RESOLUTION_M = 0.05
MAX_CELLS = 4_000_000
"""Maximum number of cells of the map; a larger floor gets larger cells."""


def is_without_map(document: Document) -> bool:
    """Return whether a task says that it has no map."""
    node, there = document.root.deepest(MAP_KEY)
    return there and node.content == NO_MAP


def open_floor(poses: Iterable[Pose2]) -> GridMap:
    """Return a map of free floor that includes the robot's start and the given poses, for tasks without map.

    Args:
        poses: poses in the frame of the start, which is also the map's frame.
    """
    points = np.array([(0.0, 0.0), *(pose[:2] for pose in poses)])
    low, size = points.min(axis=0) - MARGIN_M, np.ptp(points, axis=0) + 2.0 * MARGIN_M
    resolution = max(RESOLUTION_M, float(np.sqrt(size.prod() / MAX_CELLS)))
    rows, columns = (int(np.ceil(length / resolution)) for length in (size[1], size[0]))
    nothing = np.zeros((rows, columns), dtype=np.bool_)
    return GridMap(nothing, nothing.copy(), resolution, float(low[0]), float(low[1]))


def started_exactly(robot: RobotFile) -> RobotFile:
    """Return the robot's file without a simulated error of the start pose.

    In a task without map, the start pose defines the frame of all places, so that it has no error.
    """
    errors = robot.errors.model_copy(update={"start_mm": 0.0, "start_deg": 0.0})
    return robot.model_copy(update={"errors": errors})
