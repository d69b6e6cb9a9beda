"""File of doors and drawers, as the robot knows them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

import cv2
import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.description.things.door_shape import DoorShape, DoorTag
from handcart.files.models.model import FileModel
from handcart.robotics.navigation.maps.movable_areas import MovableArea

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document

UNKNOWN_RADIUS_M = 0.8  # of a hinged door whose file has no radius
MARGIN_M = 0.1  # around the area that a door sweeps, because its hinge is believed only
SWEPT_STEPS = 13  # positions of a leaf of which the area is made
Name = Annotated[str, Field(min_length=1, max_length=60)]


class KnownDoor(DoorShape):
    """A door or drawer in a file of doors; its motion and radius are assumptions until it is opened."""

    tags: Annotated[tuple[DoorTag, ...], Field(min_length=1)]
    """Tags on its front, by which its handle is found."""
    place: Name
    """Place of the base before it."""

    def movable_area(self) -> MovableArea:
        """Return the area that the door sweeps between closed and open, by the motion stated in the file."""
        joint = self.joint(self.handle.pose, self.radius_m or UNKNOWN_RADIUS_M)
        front, (thickness, width, height) = self.front(joint)
        half = (
            np.array([[-thickness, -width], [thickness, -width], [thickness, width], [-thickness, width]]) / 2
        )
        corners = np.column_stack([half, np.zeros(4), np.ones(4)]) @ (joint.closed @ front).T
        swept = [
            (corners @ joint.displaced(float(opening)).T)[:, :2]
            for opening in np.linspace(0.0, self.travel, SWEPT_STEPS)
        ]
        outline = cv2.convexHull(np.vstack(swept).astype(np.float32)).reshape(-1, 2).astype(np.float64)
        low = self.handle.height_m - height / 2
        return MovableArea(outline, MARGIN_M, low, low + height)


class DoorsFile(FileModel):
    """File of the doors and drawers that a robot opens and closes."""

    format: Literal["handcart-doors/1"]
    doors: dict[Name, KnownDoor]

    @override
    def contradictions(self, document: Document) -> Iterator[Finding]:
        owners: dict[tuple[str, int], str] = {}
        for name, door in self.doors.items():
            for number, tag in enumerate(door.tags):
                other = owners.setdefault((tag.family, tag.id), name)
                if other != name:
                    words = f"the tag {tag.family} {tag.id} is on {other!r} and on {name!r}"
                    path = ("doors", name, "tags", number)
                    yield document.finding(path, f"{words}; allowed: each tag on one door")


def gripper_findings(document: Document, file: DoorsFile, opening_mm: float) -> Iterator[Finding]:
    """Yield a finding for each door handle in a file that is too thick for fingers that open by `opening_mm`.
    `document` has the lines of the file, for the places of the findings.
    """
    for name, door in file.doors.items():
        if door.handle.width_mm >= opening_mm:
            wrong = f"the bar is too thick for the fingers: {door.handle.width_mm:g} mm"
            path = ("doors", name, "handle", "width_mm")
            yield document.finding(
                path if "width_mm" in door.handle.model_fields_set else path[:-1],
                f"{wrong}; allowed: less than {opening_mm:g} mm",
            )
