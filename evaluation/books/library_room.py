"""Room of generated libraries."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2

WIDTH, DEPTH = 9.0, 7.0  # [m]
STAND_OFF = 0.47  # [m] from the base's centre to a shelf's front
BOARD_HEIGHT_M = 0.70  # [m]
CLEAR_WIDTH_M = 1.0  # [m] between the side panels
OUTER_WIDTH_M = 1.04  # [m] with them
SHELF_DEPTH = 0.25  # [m]


class RoomFurniture(NamedTuple):
    """Piece of furniture in a generated library, as a box on the floor."""

    name: str
    x: float
    y: float
    length: float
    width: float
    height: float


HOME_POSE = Pose2(1.2, 1.2, 1.5707963267948966)
SHELF_POSES = (
    Pose2(2.2, 6.65, 1.5707963267948966),
    Pose2(4.5, 6.65, 1.5707963267948966),
    Pose2(6.8, 6.65, 1.5707963267948966),
    Pose2(8.65, 4.6, 0.0),
    Pose2(8.65, 2.2, 0.0),
)
"""map_T_shelf of each shelf: the middle of its front, x into the shelf."""
ROOM_FURNITURE = (
    RoomFurniture("desk", 3.0, 3.6, 1.6, 0.8, 0.75),
    RoomFurniture("counter", 5.6, 3.6, 0.9, 1.8, 1.1),
    RoomFurniture("pillar", 3.6, 1.4, 0.4, 0.4, 2.0),
    RoomFurniture("cupboard", 5.6, 0.4, 1.2, 0.6, 1.8),
)
