"""Complete report of `handcart check` on a URDF without a robot's file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from handcart.backends.urdf.robot_parts import read_part
from handcart.backends.urdf.robot_urdf import RobotUrdf, SourcePlace

from .outline import Outline, outline_of
from .report import Contents, contents_of


@dataclass(frozen=True)
class UrdfReport:
    """Checked content of a URDF, and the robot's main parts (wheels, arm, sensors) guessed from it."""

    contents: Contents
    outline: Outline
    text: str
    """The URDF with meshes named by absolute paths."""


def urdf_report(path: Path) -> UrdfReport:
    """Check a URDF; return its content with remarks on it, and the robot's main parts guessed from it."""
    part = read_part(path.name, path.parent)
    places = {key: SourcePlace(part.file, *spot) for key, spot in part.places.items()}
    whole = RobotUrdf(part.text, places, doubts=part.doubts)
    return UrdfReport(contents_of(whole), outline_of(part.text), part.text)
