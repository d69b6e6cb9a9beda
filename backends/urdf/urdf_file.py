"""Reading a URDF: within limits, found sound, each fault at its line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.files.xml_file import read_xml_text
from handcart.robotics.kinematics.urdf_faults import urdf_faults


class UrdfText(NamedTuple):
    """A URDF that can be used."""

    text: str
    doubts: Sequence[Finding]
    """What is wrong in it, but keeps nobody from using it."""


def read_urdf_file(path: Path, shown: str | None = None) -> UrdfText:
    """The text of a robot's URDF.

    Args:
        path: of the file.
        shown: as what it is told of; left out: `path`.

    Raises:
        FileError: it can't be read, or is no XML within the limits of `read_xml_text`, or no sound URDF.
    """
    text = read_xml_text(path)
    faults = [(_finding(shown or str(path), *each), each.mild) for each in urdf_faults(text)]
    if grave := [finding for finding, mild in faults if not mild]:
        raise FileError(grave)
    return UrdfText(text, [finding for finding, _ in faults])


def _finding(file: str, line: int, column: int, message: str, _mild: bool) -> Finding:
    return Finding(file, line, column, message)
