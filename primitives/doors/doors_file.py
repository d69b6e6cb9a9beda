"""File of doors and drawers, as the robot knows them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field
from typing_extensions import override

from handcart.backends.description.door_shape import DoorShape, DoorTag
from handcart.files.models.model import FileModel

if TYPE_CHECKING:
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document

Name = Annotated[str, Field(min_length=1, max_length=60)]


class KnownDoor(DoorShape):
    """A door or a drawer; its motion and its radius are believed, and measured when it is opened."""

    tags: Annotated[tuple[DoorTag, ...], Field(min_length=1)]
    """Tags on its front, by which its handle is found."""
    place: Name
    """Place of the base before it."""


class DoorsFile(FileModel):
    """Doors and drawers that a robot opens and closes."""

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
    """Yield handles that are too thick for fingers with an opening."""
    for name, door in file.doors.items():
        if door.handle.width_mm >= opening_mm:
            wrong = f"the bar is too thick for the fingers: {door.handle.width_mm:g} mm"
            path = ("doors", name, "handle", "width_mm")
            yield document.finding(
                path if "width_mm" in door.handle.model_fields_set else path[:-1],
                f"{wrong}; allowed: less than {opening_mm:g} mm",
            )
