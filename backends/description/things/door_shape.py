"""A door or a drawer in files: its handle, its motion and its tags."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.manipulation.doors.door_joint import DoorJoint
from handcart.robotics.perception.landmarks.tag_family import TagFamily, tags_of

from .printed_tag import FACE_TURNS

FINGERTIP_ROOM_MM = 30.0  # free depth behind a bar, for finger tips
EDGE_M = 0.06  # from the middle of a handle to the edge of its door


class DoorTag(FileModel):
    """A square tag on the front of a door or drawer, next to the handle, and its position relative to the
    handle.
    """

    family: TagFamily = "apriltag_36h11"
    id: Annotated[int, Field(ge=0)]
    side_mm: Annotated[float, Field(gt=0.0, le=500.0)]
    """Side of the tag's black square."""
    right_mm: float = 0.0
    """Offset of the tag's middle from the handle's middle, to the right for somebody in front of the door."""
    up_mm: float = 0.0
    """Offset of the tag's middle from the handle's middle, upwards."""

    @model_validator(mode="after")
    def _in_family(self) -> Self:
        if self.id >= tags_of(self.family):
            raise ValueError(f"{self.family} has no tag {self.id}; allowed: 0 to {tags_of(self.family) - 1}")
        return self

    def on_door(self, standoff: float) -> Transform:
        """Return the pose of the tag in the handle frame, handle_T_tag (4, 4).

        Handle frame: x away from the closed door, y to the right for somebody in front of it, z up. Tag
        frame: x right, y up, z away from the door's front.

        Args:
            standoff: distance from the front of the door to the middle of the handle's bar, in [m].
        """
        beside = (-standoff, self.right_mm / 1e3, self.up_mm / 1e3)
        return transform(beside, FACE_TURNS["+x"])


class DoorHandle(FileModel):
    """Round bar on the front of a door or drawer as its handle, with the bar's pose on the map while the door
    or drawer is closed.
    """

    x_m: float
    y_m: float
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    heading_deg: float = 0.0
    """Direction on the map from the closed door towards somebody in front of it, counter-clockwise from the x
    axis.
    """
    bar: Literal["vertical", "horizontal"] = "vertical"
    width_mm: Annotated[float, Field(gt=0.0, le=100.0)] = 16.0
    """Diameter of the bar."""
    length_mm: Annotated[float, Field(gt=0.0, le=2000.0)] = 120.0
    standoff_mm: Annotated[float, Field(le=300.0)] = 45.0
    """Distance from the front of the door to the middle of the bar."""

    @model_validator(mode="after")
    def _leaves_room(self) -> Self:
        least = FINGERTIP_ROOM_MM + self.width_mm / 2
        if self.standoff_mm < least:
            wrong = f"no room for fingers behind the bar: {self.standoff_mm:g} mm"
            raise ValueError(f"{wrong}; allowed: standoff_mm of at least {least:g}")
        return self

    @property
    def pose(self) -> Transform:
        """Pose map_T_handle (4, 4) of the handle while the door is closed; its x axis points away from the
        door, z up.
        """
        return transform((self.x_m, self.y_m, self.height_m), (0.0, 0.0, math.radians(self.heading_deg)))

    @property
    def width(self) -> float:
        """Diameter of the handle's bar, in [m]."""
        return self.width_mm / 1e3

    @property
    def standoff(self) -> float:
        """Distance from the front of the door to the middle of the handle's bar, in [m]."""
        return self.standoff_mm / 1e3


class DoorShape(FileModel):
    """Shape and motion of a door or a drawer, as stated in a world's file or in the robot's knowledge."""

    motion: Literal["hinged", "sliding"] = "hinged"
    """A hinge with a vertical axis, or a drawer's level slide along the heading of the handle."""
    handle: DoorHandle
    hinge: Literal["left", "right"] = "left"
    """Side of the hinge, for somebody in front of the door."""
    opens: Literal["towards", "away"] = "towards"
    """Direction in which a hinged door opens, for somebody in front of it."""
    radius_m: Annotated[float, Field(ge=0.1, le=3.0)] | None = None
    """Distance from the hinge's axis to the handle."""
    travel_deg: Annotated[float, Field(gt=0.0, le=180.0)] = 90.0
    """Opening of a hinged door at its stop."""
    travel_mm: Annotated[float, Field(gt=0.0, le=2000.0)] = 400.0
    """Opening of a drawer at its stop."""
    opened_deg: Annotated[float, Field(ge=0.0, le=180.0)] = 0.0
    """Opening of a hinged door at the start."""
    opened_mm: Annotated[float, Field(ge=0.0, le=2000.0)] = 0.0
    """Opening of a drawer at the start."""
    height_mm: Annotated[float, Field(gt=0.0, le=3000.0)] = 500.0
    """Height of its front, with the handle in the middle."""
    length_mm: Annotated[float, Field(gt=0.0, le=3000.0)] = 400.0
    """Width of the front of a drawer; that of a hinged door follows from its radius."""
    thickness_mm: Annotated[float, Field(gt=0.0, le=200.0)] = 20.0
    tags: tuple[DoorTag, ...] = ()

    @property
    def is_hinged(self) -> bool:
        """True if the door turns about a hinge, False if it is a drawer that slides."""
        return self.motion == "hinged"

    @property
    def travel(self) -> float:
        """Largest opening of the door in [rad], or of a drawer in [m], at which it meets its stop."""
        return math.radians(self.travel_deg) if self.is_hinged else self.travel_mm / 1e3

    @property
    def opened(self) -> float:
        """Opening of the door at the start of a run, in [rad], or of a drawer in [m]."""
        return math.radians(self.opened_deg) if self.is_hinged else self.opened_mm / 1e3

    def joint(self, closed: Transform, radius: float) -> DoorJoint:
        """Return the joint of a door or drawer, in the same frame as the handle's pose `closed`.

        Args:
            closed: (4, 4) pose of the handle while the door is closed.
            radius: distance from the hinge's axis to the handle, in [m]; ignored for a drawer.
        """
        outwards = 1.0 if self.opens == "towards" else -1.0
        if not self.is_hinged:
            return DoorJoint(np.asarray(closed), None, outwards)
        # Seen from in front of a door, left is -y of its handle; a turn about z moves what is at +y to -x.
        side = -1.0 if self.hinge == "left" else 1.0
        behind = min(self.handle.standoff, 0.9 * radius)
        across = side * math.sqrt(radius**2 - behind**2)
        return DoorJoint(np.asarray(closed), (-behind, across), side * outwards)

    def front(self, joint: DoorJoint) -> tuple[Transform, tuple[float, float, float]]:
        """Return the pose and the size of the front, which is the panel of a door or drawer that carries the
        handle.

        Returns:
            handle_T_front (4, 4) of the front's middle, with the axes of the handle frame; and thickness,
            width and height of the front, in [m].
        """
        middle, width = 0.0, self.length_mm / 1e3
        if joint.hinge is not None:
            middle = (joint.hinge[1] - math.copysign(EDGE_M, joint.hinge[1])) / 2
            width = abs(joint.hinge[1]) + EDGE_M
        thickness, height = self.thickness_mm / 1e3, self.height_mm / 1e3
        behind = self.handle.standoff + thickness / 2
        return transform((-behind, middle, 0.0)), (thickness, width, height)
