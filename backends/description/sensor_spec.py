"""Base classes of the sensors in a robot's file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field

from handcart.files.errors import HandcartError
from handcart.files.models.model import FileModel

SensorName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=60)]
"""Name of a sensor in a robot's file."""
Carrier = Literal["base", "any"]
"""Part of the robot that a sensor may be mounted on: the base, or any part whose joints are read."""


class UnreadableFile(HandcartError, ValueError):
    """Error: a file named in a sensor's section of the robot's file is missing, or outside that file's
    folder.
    """

    def __init__(self, key: str, wrong: str) -> None:
        self.key = key
        super().__init__(wrong)


class SensorSpec(FileModel):
    """Base class of the sections of a robot's file that describe a sensor.

    A subclass for a kind of sensor adds its own keys, and sets the default of `kind`.
    """

    kind: str
    """Kind of the sensor."""
    CARRIER: ClassVar[Carrier | None] = None
    """Parts of the robot that may carry the sensor; None for a sensor without a frame in the URDF."""

    def link(self, name: str) -> str:
        """Return the URDF's link on which the sensor `name` is mounted; "" for a sensor without a frame."""
        return ""

    def without_errors(self) -> Self:
        """Return the description of the same sensor without noise, bias and other errors."""
        return self

    def with_files(self, folder: Path) -> Self:
        """Return the sensor with the content of the files that its section names, relative to `folder`.

        Raises:
            UnreadableFile: a file is missing, or outside the folder.
            FileError: the content of a file is invalid.
        """
        return self


class MountedSensorSpec(SensorSpec):
    """Base class of descriptions, in a robot's file, of sensors that have a frame in the robot's URDF."""

    CARRIER: ClassVar[Carrier | None] = "base"
    frame: Annotated[str, Field(min_length=1)] | None = None
    """Link of the URDF that is the sensor's frame (default: the link with the sensor's name)."""

    def link(self, name: str) -> str:
        """Return the URDF's link on which the sensor `name` is mounted."""
        return self.frame or name
