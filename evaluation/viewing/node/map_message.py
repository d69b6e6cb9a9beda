"""The robot's map as a message."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np

from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.serving_link import ServingLink
from handcart.robotics.navigation.maps.grid_map import GridMap

from .marker_messages import MAP_FRAME

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Cells of a `nav_msgs/OccupancyGrid`."""


def map_message(link: ServingLink, grid: GridMap) -> Any:
    """Return the ROS message `OccupancyGrid` of a map."""
    message = link.message("nav_msgs/OccupancyGrid")
    message.header.frame_id = MAP_FRAME
    set_stamp(message.header, link.now())
    cells = np.where(grid.occupied, OCCUPIED, np.where(grid.unknown, UNKNOWN, FREE)).astype(np.int8)
    info = message.info
    info.resolution, info.height, info.width = float(grid.resolution), *map(int, cells.shape)
    info.origin.position.x, info.origin.position.y = float(grid.origin_x), float(grid.origin_y)
    info.origin.orientation.w = 1.0
    message.data = array("b", cells.tobytes())
    return message
