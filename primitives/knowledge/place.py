"""The named places of a map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from handcart.backends.robot.localization.determination import PoseNeed
from handcart.files.maps.map_file import load_map as load_map
from handcart.files.models.loading import Loaded, load_document
from handcart.files.models.model import FileModel
from handcart.files.yaml.yaml_document import Document, read_document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform

from .ros_goals import GOAL_LIST_KEYS, goals_as_places

ARRIVED_MM, ARRIVED_DEG = 40.0, 1.0  # of a place that says nothing
DOCKED_MM = 24.0  # of one where the base docks
CAR_ARRIVED_MM, CAR_ARRIVED_DEG = 1500.0, 20.0
"""Default tolerances of a place that a car drives to, which can't turn on the spot nor move sideways.

After a detour a car arrives turned by up to 9 degrees; 3 sigma of its heading are some 6 more.
"""
CAR_DRIVE_KIND = "ackermann"  # kind of drive

Positive = Annotated[float, Field(gt=0.0)]


class Shelf(FileModel):
    """A shelf in front of a place.

    The shelf's frame has x into the shelf, y to the left and z up. Its origin is the middle of the shelf's
    front edge at the height of the board.
    """

    distance_m: Positive
    """Distance from the base's centre at the place to the shelf's front, straight ahead."""
    width_m: Positive
    """Width between the side panels."""
    board_m: Positive
    """Height of the board that carries the books."""
    front_m: Positive
    """Width of the front that the range sensor sees."""


class DirectedTolerance(FileModel):
    """Tolerance of a base's position at a place, along and across the place's heading."""

    along: Positive
    """Tolerance in the direction of the place's heading, ahead or behind, in [mm]."""
    across: Positive
    """Tolerance at right angles to the place's heading, in [mm]."""


class Place(FileModel):
    """Named pose of the base on the map, with its tolerances and the object in front of it, if any."""

    x_m: float
    y_m: float
    heading_deg: float
    shelf: Shelf | None = None
    tolerance_mm: Positive | DirectedTolerance | None = None
    """Tolerance of the base's position, which includes 3 sigma: in any direction, or along and across.
    (default: 40; 24 where it docks; 1500 for a car)
    """
    tolerance_deg: Positive | None = None
    """Tolerance of the base's heading, which includes 3 sigma. (default: 1; 20 for a car)"""

    @property
    def pose(self) -> Pose2:
        """map_T_base of a robot at the place."""
        return Pose2(self.x_m, self.y_m, math.radians(self.heading_deg))

    @property
    def docks(self) -> bool:
        """True if the base docks at this place, in front of an object with a straight front."""
        return self.shelf is not None

    def need_of(self, drive: str) -> PoseNeed:
        """Return the required accuracy of a base's pose at the place.

        Args:
            drive: kind of the robot's drive, such as "ackermann" for a car; a car's default tolerances are
                larger.
        """
        usual_mm, usual_deg = DOCKED_MM if self.docks else ARRIVED_MM, ARRIVED_DEG
        if drive == CAR_DRIVE_KIND:
            usual_mm, usual_deg = CAR_ARRIVED_MM, CAR_ARRIVED_DEG
        position = usual_mm if self.tolerance_mm is None else self.tolerance_mm
        heading = math.radians(usual_deg if self.tolerance_deg is None else self.tolerance_deg)
        if isinstance(position, DirectedTolerance):
            theta = math.radians(self.heading_deg)
            return PoseNeed(position.along / 1e3, heading, position.across / 1e3, theta)
        return PoseNeed(position / 1e3, heading)

    @property
    def map_T_shelf(self) -> Transform:
        """Pose (4, 4) of the shelf frame on the map.

        Raises:
            ValueError: the place is not in front of a shelf.
        """
        shelf = self._shelf()
        return self.pose.compose(Pose2(shelf.distance_m, 0.0, 0.0)).lift(shelf.board_m)

    @property
    def front(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """The shelf's front, (2, 2): its ends on the map, in [m]."""
        shelf = self._shelf()
        ends = np.array([[shelf.distance_m, -0.5 * shelf.front_m], [shelf.distance_m, 0.5 * shelf.front_m]])
        return self.pose.apply(ends)

    def _shelf(self) -> Shelf:
        if self.shelf is None:
            raise ValueError("no shelf is at this place")
        return self.shelf


class Places(FileModel):
    """File of the named places of a map, which are poses of the base with tolerances."""

    format: Literal["handcart-places/1"]
    places: dict[str, Place]


def load_places(path: Path) -> Loaded[Places]:
    """Return the places in a file of places, or of goals for nav2; raises `FileError` with every finding."""
    document = read_document(path)
    return load_document(goals_as_places(document) if is_goals(document) else document, Places)


def is_goals(document: Document) -> bool:
    """Return True if a file contains navigation goals, such as those of nav2; False if it is a file of
    places.

    The file is a list, or has a list under `waypoints`, `goals` or `poses`, or consists of lines `name: [x,
    y, theta]`; it has no key `format`.
    """
    content = document.root.content
    if isinstance(content, dict):
        by_name = bool(content) and all(isinstance(goal.content, list) for goal in content.values())
        return "format" not in content and (by_name or any(key in content for key in GOAL_LIST_KEYS))
    return isinstance(content, list)
