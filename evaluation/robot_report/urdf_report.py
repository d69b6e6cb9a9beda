"""All that `handcart check` tells about a URDF that no robot's file names yet."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from handcart.backends.urdf.robot_parts import read_part
from handcart.backends.urdf.robot_urdf import RobotUrdf, SourcePlace

from .drafting.outline import Outline, outline_of
from .report import Contents, contents_of


@dataclass(frozen=True)
class UrdfReport:
    """A URDF, and what it lets one guess."""

    contents: Contents
    outline: Outline
    text: str
    """Its meshes named by absolute paths."""


def urdf_report(path: Path) -> UrdfReport:
    """Look at a URDF.

    Raises:
        FileError: something is wrong in it.
        UrdfError: it isn't there.
    """
    part = read_part(path.name, path.parent)
    places = {key: SourcePlace(part.file, *spot) for key, spot in part.places.items()}
    whole = RobotUrdf(part.text, places, doubts=part.doubts)
    return UrdfReport(contents_of(whole), outline_of(part.text), part.text)
