"""The URDFs that a robot is put together from, and where their meshes lie."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator

from files.errors import FileError, UnsafePath
from files.inside import portable, resolve_inside
from files.model import FileModel
from files.suggest import listed
from robotics.kinematics.urdf_assembly import Part, read_urdf, with_mesh_files, with_part

from .mesh_path import is_mesh, mesh_path
from .urdf_file import read_urdf_file

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
        FileError: what is wrong in one of them.
    """
    try:
        text = read_part(urdf, folder)
    except FileError:  # has the URDF's own lines
        raise
    except ValueError as error:
        raise UrdfError(str(error)) from error
    for number, each in enumerate(parts):
        try:
            text = with_part(text, each.part(folder))
        except FileError:
            raise
        except ValueError as error:
            raise UrdfError(str(error), number) from error
    return text


def read_part(urdf: str, folder: Path) -> str:
    """A URDF's text, its meshes named by absolute paths.

    Args:
        urdf: as in a robot's file.
        folder: where that lies.

    Raises:
        FileError: what is wrong in it.
        ValueError: it isn't there, or a link's collision mesh isn't; or a mesh lies outside (`mesh_path`).
    """
    path, root = _found(urdf, folder)
    if not path.is_file():
        raise ValueError(f"there is no text file {urdf!r}; allowed: a URDF")
    text = read_urdf_file(path)
    robot = read_urdf(text)
    if robot.find(".//mesh") is None:
        return text
    names = {each.get("filename", "") for each in robot.iterfind("link//mesh")}
    files = {name: mesh_path(name, path, root) for name in sorted(names)}
    solid = {each.get("filename", "") for each in robot.iterfind("link/collision//mesh")}
    if missing := sorted(name for name in solid if not is_mesh(files[name])):
        where = f"looked for in {path.parent} and above"
        raise ValueError(f"{urdf!r} names meshes that aren't there: {listed(missing)}; {where}")
    return with_mesh_files(text, lambda name: str(files.get(name, name)))


def _found(urdf: str, folder: Path) -> tuple[Path, Path]:
    """Its file, and the folder that it and its meshes are in."""
    if not urdf.startswith(PACKAGE):
        return resolve_inside(folder, urdf), folder
    package, _, path = urdf.removeprefix(PACKAGE).partition("/")
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        how = "; it comes with: pip install 'handcart[sim]'" if package.startswith("pybullet") else ""
        raise ValueError(f"there is no Python package {package!r}; allowed: an installed one{how}")
    root = Path(spec.submodule_search_locations[0])
    return resolve_inside(root, path), root
