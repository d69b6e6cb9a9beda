"""Paths of the meshes that a URDF names."""

from __future__ import annotations

import posixpath
import stat
from itertools import chain
from pathlib import Path
from urllib.parse import unquote

from handcart.files.errors import UnsafePath
from handcart.files.inside import resolve_inside
from handcart.files.printable import printable
from handcart.files.suggest import did_you_mean

from .packages import package_folders

MAX_MESH_BYTES = 100_000_000  # [bytes] of a mesh


def mesh_path(name: str, urdf: Path, root: Path) -> Path:
    """Return the path of a mesh, relative to the URDF's folder or in a package.

    `package://NAME/PATH` (or `model://`) is searched as a folder NAME next to the URDF or next to one of
    the folders that contain it, then where `package_folders` finds NAME. An absolute path, with or without
    `file://`, is used unchanged: ROS tools write those. If no such file exists, the name is tried again
    with `%20` and similar escapes decoded. The file need not exist.

    Args:
        name: as in the URDF.
        urdf: the URDF's file.
        root: folder that a relative path must not leave, except into the ROS package that holds the URDF.

    Raises:
        UnsafePath: the path leads out of its package, or out of `root`, by `..` or by a link.
    """
    found = _place(name, urdf, root)
    decoded = unquote(name)
    if decoded == name or is_mesh(found) or printable(decoded) != decoded:
        return found
    again = _place(decoded, urdf, root)
    return again if is_mesh(again) else found


def _place(name: str, urdf: Path, root: Path) -> Path:
    _, scheme, rest = name.rpartition("://")
    if scheme and not name.startswith("file://"):
        return _in_package(name, rest, urdf)
    if rest.startswith("/"):
        return Path(rest)
    return resolve_inside(_root(urdf, root), rest, start=urdf.parent)


def is_mesh(path: Path) -> bool:
    """Return whether a path is a regular file of at most `MAX_MESH_BYTES`."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return False
    return stat.S_ISREG(status.st_mode) and status.st_size <= MAX_MESH_BYTES


def _in_package(name: str, rest: str, urdf: Path) -> Path:
    package = rest.partition("/")[0]
    inside = posixpath.normpath(rest)
    if not package or package == ".." or not inside.startswith(f"{package}/"):
        raise UnsafePath(name[:1024], "leads out of its package")
    beside = (folder / rest for folder in urdf.resolve().parents)
    installed = (folder / rest.partition("/")[2] for folder in package_folders(package))
    places = list(chain(beside, installed))
    found = next((place for place in places if is_mesh(place)), None)
    if found is None:  # the package itself is there: a message can name a file in it
        found = next((place for place in places if did_you_mean(place)), urdf.parent / rest)
    return found


def _root(urdf: Path, root: Path) -> Path:
    """Return the ROS package that holds the URDF, where that reaches further than `root`."""
    packages = (folder for folder in urdf.resolve().parents if (folder / "package.xml").is_file())
    package = next(packages, None)
    return package if package is not None and root.resolve().is_relative_to(package) else root
