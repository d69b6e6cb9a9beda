"""The URDFs that a robot is put together from, read and found sound, and where their meshes lie."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import AfterValidator

from handcart.files.errors import FileError, Finding, UnsafePath
from handcart.files.extras import lack
from handcart.files.inside import portable, resolve_inside
from handcart.files.models.model import FileModel
from handcart.files.suggest import did_you_mean, suggest
from handcart.files.xml_file import read_xml_text
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, read_mesh
from handcart.robotics.kinematics.urdf_assembly import Part, with_mesh_files
from handcart.robotics.kinematics.urdf_faults import urdf_faults
from handcart.robotics.kinematics.urdf_pruning import UnknownJoint, prune, without_joints
from handcart.robotics.kinematics.urdf_reading import UrdfElement, read_urdf

from .collada_unit import collada_unit_m
from .mesh_path import is_mesh, mesh_path
from .packages import PACKAGE_NAME, PACKAGE_PREFIX, PACKAGE_SOURCES, package_folders

KeyPath = tuple[str | int, ...]


class UrdfError(ValueError):
    """Error: a robot's URDF is missing, or cannot be mounted where the robot's file says."""

    def __init__(self, wrong: str, key: KeyPath | None = None) -> None:
        self.key = key
        """Key of the robot's file that causes the error; None: the key that names the URDF."""
        super().__init__(wrong)


def _place(text: str) -> str:
    if not text.startswith(PACKAGE_PREFIX):
        return portable(text)
    package, _, path = text.removeprefix(PACKAGE_PREFIX).partition("/")
    if not PACKAGE_NAME.fullmatch(package):
        raise UnsafePath(text[:100], "names no package; allowed: package://NAME/PATH")
    portable(path)
    return text


UrdfPlace = Annotated[str, AfterValidator(_place)]
"""A path from the robot's file, or `package://NAME/PATH` in a package of Python or ROS."""


class PartSpec(FileModel):
    """URDF of a robot's part, which is mounted on a link of a part that precedes it in the robot's file."""

    urdf: UrdfPlace
    """A path from the robot's file, or `package://NAME/PATH` in a package of Python or ROS."""
    srdf: UrdfPlace | None = None
    """MoveIt's SRDF file for the part: which of its links may touch each other (`disable_collisions`)."""
    without: tuple[str, ...] = ()
    """Joints that are removed with all links behind them: the fingers of a maker's hand, say."""
    onto: str
    """The link to which the part's root link is fixed."""
    xyz_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position of the root link in the frame of the link `onto`."""
    rpy_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the root link in the frame of the link `onto`."""
    prefix: str = ""
    """Prefix of the names of the part's links and joints, needed where two parts share a name."""

    def part(self, text: str) -> Part:
        """Convert this entry of a robot's file to a part that can be mounted.

        Args:
            text: text of the part's URDF.
        """
        roll, pitch, yaw = (math.radians(angle) for angle in self.rpy_deg)
        return Part(text, self.onto, self.xyz_m, (roll, pitch, yaw), self.prefix)


class ReadPart(NamedTuple):
    """Text of a usable URDF, with the line and column of its links and joints, and its faults that do not
    prevent its use.
    """

    file: str
    text: str
    """Text of the URDF, in which meshes are named by absolute paths."""
    places: Mapping[tuple[str, str], tuple[int, int]]
    """Line and column of each element in its file, by ("link" or "joint", name)."""
    doubts: Sequence[Finding]
    """Faults that do not prevent its use."""


def read_part(urdf: str, folder: Path, without: Sequence[str] = ()) -> ReadPart:
    """Read a URDF and check that it can be used.

    Args:
        urdf: path or `package://NAME/PATH` of the URDF, as in a robot's file.
        folder: folder of the robot's file.
        without: joints that are removed with all links behind them.

    Raises:
        FileError: the URDF, or a mesh of a link, is faulty.
        UrdfError: the URDF is missing, or lacks a joint that `without` names.
    """
    path, root, shown = _found(urdf, folder)
    if not path.is_file():
        raise UrdfError(f"missing text file {urdf!r}; {did_you_mean(path)}allowed: a URDF")
    try:
        text, doubts = read_urdf_file(path, shown, without)
    except UnknownJoint as error:
        wrong = f"{urdf} has no joint {error.joint!r}{suggest(error.joint, error.known)}"
        raise UrdfError(wrong, ("without", list(without).index(error.joint))) from error
    robot = read_urdf(text)
    prune(robot, without)
    places = {
        (str(item.tag), item.get("name", "")): (item.line, item.column)
        for item in robot
        if isinstance(item, UrdfElement) and item.tag in ("link", "joint")
    }
    if robot.find(".//mesh") is not None:
        files = _mesh_files(robot, path, root, shown)
        text = with_mesh_files(
            text,
            lambda name: str(files[name].path) if name in files else name,
            lambda name: files[name].unit_m if name in files else 1.0,
        )
    text = without_joints(text, without)
    return ReadPart(shown, text, places, doubts)


def read_srdf(srdf: str, folder: Path) -> str:
    """Return the text of an SRDF, MoveIt's file of a robot's semantics such as groups and postures.

    Args:
        srdf: path or `package://NAME/PATH` of the SRDF, as in a robot's file.
        folder: folder of the robot's file.

    Raises:
        FileError: the file cannot be read, or is not well-formed XML.
        UrdfError: the file or its package is missing.
    """
    path, _, _ = _found(srdf, folder)
    if not path.is_file():
        raise UrdfError(f"missing text file {srdf!r}; {did_you_mean(path)}allowed: a SRDF")
    return read_xml_text(path)


class _MeshFile(NamedTuple):
    """A mesh that a URDF names."""

    path: Path
    unit_m: float
    """Unit of its coordinates, in [m]."""


def _mesh_files(robot: UrdfElement, path: Path, root: Path, shown: str) -> dict[str, _MeshFile]:
    """Return the mesh files of all links, by name.

    Raises:
        FileError: a mesh is at a forbidden path; or a collision mesh is missing, cannot be read or encloses
            no volume.
    """
    found: dict[str, _MeshFile] = {}
    faults = []
    for link in robot.findall("link"):
        for kind in ("collision", "visual"):
            for mesh in link.iterfind(f"{kind}/geometry/mesh"):
                assert isinstance(mesh, UrdfElement)
                name = mesh.get("filename", "")
                wrong = None
                try:
                    file = mesh_path(name, path, root)
                    found[name] = _MeshFile(file, collada_unit_m(file) if is_mesh(file) else 1.0)
                except (UnsafePath, ValueError) as error:
                    wrong = str(error)
                if wrong is None and kind == "collision":
                    wrong = _mesh_fault(found[name], mesh.get("scale", "1 1 1"))
                if wrong is not None:
                    words = f"link {link.get('name')!r}: mesh {name!r}: {wrong}"
                    faults.append(Finding(shown, mesh.line, mesh.column, words))
    if faults:
        raise FileError(faults)
    return found


def _mesh_fault(mesh_file: _MeshFile, scale: str) -> str | None:
    file, unit = mesh_file
    if not is_mesh(file):
        allowed = "a file beside the URDF, or beside or above it in its package"
        return f"it isn't there; {did_you_mean(file)}allowed: {allowed}"
    if wrong := lack("a mesh that collides", "arm"):
        return wrong
    x, y, z = (unit * float(word) for word in scale.split())
    try:
        mesh = read_mesh(str(file), (x, y, z))
    except ValueError as error:
        return str(error)
    try:
        hull_of_mesh(mesh, "")
    except ValueError:
        return "it encloses nothing; allowed: a closed surface"
    return None


def _found(urdf: str, folder: Path) -> tuple[Path, Path, str]:
    """Return a URDF's file, the folder that it and its meshes are in, and how the file is shown."""
    if not urdf.startswith(PACKAGE_PREFIX):
        return resolve_inside(folder, urdf), folder, str(folder / urdf)
    package, _, path = urdf.removeprefix(PACKAGE_PREFIX).partition("/")
    roots = list(package_folders(package))
    if not roots:
        source = PACKAGE_SOURCES.get(package)
        how = f"; it comes with: pip install {source}" if source else ""
        raise UrdfError(f"missing package {package!r}; allowed: {_PACKAGES}{how}")
    root = next((root for root in roots if (root / path).is_file()), roots[0])
    return _inside(root, path), root, str(_inside(root, path))


def _inside(root: Path, path: str) -> Path:
    """Return a file of a package; its folder may hold links into another one, as after `colcon
    --symlink-install`.

    Raises:
        UnsafePath: the path leads out of the package by `..`.
    """
    if ".." in path.split("/"):
        return resolve_inside(root, path)
    portable(path)
    return root / path


_PACKAGES = "an installed Python package, or one in AMENT_PREFIX_PATH, ROS_PACKAGE_PATH or a folder `share`"


class UrdfText(NamedTuple):
    """Text of a usable URDF, and the minor faults found in it, which do not prevent its use."""

    text: str
    doubts: Sequence[Finding]
    """Faults that do not prevent its use."""


def read_urdf_file(path: Path, shown: str | None = None, without: Sequence[str] = ()) -> UrdfText:
    """Read the text of a robot's URDF.

    Args:
        path: path of the file.
        shown: file name in the findings (default: `path`).
        without: joints that are not checked, nor the links that they carry.

    Raises:
        FileError: the file cannot be read, is not XML within the limits of `read_xml_text`, or is not a valid
            URDF.
        UnknownJoint: the URDF lacks a joint that `without` names.
    """
    text = read_xml_text(path)
    faults = [(_finding(shown or str(path), *fault), fault.mild) for fault in urdf_faults(text, without)]
    if grave := [finding for finding, mild in faults if not mild]:
        raise FileError(grave)
    return UrdfText(text, [finding for finding, _ in faults])


def _finding(file: str, line: int, column: int, message: str, _mild: bool) -> Finding:
    return Finding(file, line, column, message)
