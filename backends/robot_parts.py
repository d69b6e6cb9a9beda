"""The URDFs that a robot is put together from, and where their meshes lie."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator

from files.errors import UnsafePath
from files.inside import portable, resolve_inside
from files.model import FileModel
from files.suggest import listed
from robotics.kinematics.urdf_assembly import Part, read_urdf, with_mesh_files, with_part

PACKAGE = "package://"
_NAME = re.compile(r"[A-Za-z_]\w*")


class UrdfError(ValueError):
    """A URDF of a robot's file is missing, or can't be put where the file says."""

    def __init__(self, wrong: str, part: int | None = None) -> None:
        self.part = part
        """Which of the parts; None: the robot's own URDF."""
        super().__init__(wrong)


def _place(text: str) -> str:
    if not text.startswith(PACKAGE):
        return portable(text)
    package, _, path = text.removeprefix(PACKAGE).partition("/")
    if not _NAME.fullmatch(package):
        raise UnsafePath(text[:100], "names no package; allowed: package://NAME/PATH")
    portable(path)
    return text


UrdfPlace = Annotated[str, AfterValidator(_place)]
"""A path from the robot's file, or `package://NAME/PATH` in an installed Python package."""


class PartSpec(FileModel):
    """A URDF that is fixed, as it is, onto what stands before it in the file."""

    urdf: UrdfPlace
    """A path from the robot's file, or `package://NAME/PATH` in an installed Python package."""
    onto: str
    """The link that carries its root link."""
    xyz_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the root link stands in that link."""
    rpy_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Its roll, pitch and yaw there."""
    prefix: str = ""
    """Put before the names of its links and joints, where two parts share some."""

    def part(self, folder: Path) -> Part:
        """What it says, with the URDF's text, the robot's file lying in `folder`; raises ValueError."""
        roll, pitch, yaw = (math.radians(angle) for angle in self.rpy_deg)
        text = read_part(self.urdf, folder)
        return Part(text, self.onto, self.xyz_m, (roll, pitch, yaw), self.prefix)


def assembled(urdf: str, parts: Sequence[PartSpec], folder: Path) -> str:
    """The URDF of a robot whose file lies in `folder`: its own, and its parts one after the other.

    Raises:
        UrdfError: one of them is missing, or can't be put there.
    """
    try:
        text = read_part(urdf, folder)
    except ValueError as error:
        raise UrdfError(str(error)) from error
    for number, each in enumerate(parts):
        try:
            text = with_part(text, each.part(folder))
        except ValueError as error:
            raise UrdfError(str(error), number) from error
    return text


def read_part(urdf: str, folder: Path) -> str:
    """A URDF's text, its meshes named by absolute paths.

    Args:
        urdf: as in a robot's file.
        folder: where that lies.

    Raises:
        ValueError: it isn't there, or is no URDF, or a link's collision mesh isn't there.
    """
    path = _found(urdf, folder)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise ValueError(f"there is no text file {urdf!r}; allowed: a URDF") from None
    robot = read_urdf(text)
    if robot.find(".//mesh") is None:
        return text
    solid = [each.get("filename", "") for each in robot.iterfind(".//collision//mesh")]
    if missing := sorted({name for name in solid if not mesh_file(name, path).is_file()}):
        where = f"looked for in {path.parent} and above"
        raise ValueError(f"{urdf!r} names meshes that aren't there: {listed(missing)}; {where}")
    return with_mesh_files(text, lambda name: str(mesh_file(name, path)))


def mesh_file(name: str, urdf: Path) -> Path:
    """Where a mesh lies that a URDF names: from its folder, or in a ROS package above it.

    `package://NAME/PATH` (or `model://`) is looked for as a folder NAME beside the URDF or beside one of the
    folders that hold it. The file need not exist.
    """
    _, scheme, rest = name.rpartition("://")
    if not scheme or name.startswith("file://"):
        return urdf.parent / rest
    places = [folder / rest for folder in urdf.resolve().parents]
    return next((place for place in places if place.is_file()), urdf.parent / rest)


def _found(urdf: str, folder: Path) -> Path:
    if not urdf.startswith(PACKAGE):
        return resolve_inside(folder, urdf)
    package, _, path = urdf.removeprefix(PACKAGE).partition("/")
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        how = "; it comes with: pip install 'handcart[sim]'" if package.startswith("pybullet") else ""
        raise ValueError(f"there is no Python package {package!r}; allowed: an installed one{how}")
    return resolve_inside(Path(spec.submodule_search_locations[0]), path)
