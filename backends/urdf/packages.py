"""Folders of the packages that `package://NAME/PATH` names: Python packages, ROS packages, and data
packages.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

PACKAGE_PREFIX = "package://"
PACKAGE_NAME = re.compile(r"[A-Za-z_][\w-]*")
PACKAGE_SOURCES = {
    "example-robot-data": "'handcart[robots]'",
    "mani_skill": "--no-deps mani-skill",
    "pybullet_data": "'handcart[pybullet]'",
    "stretch4_urdf": "--no-deps hello-robot-stretch4-urdf",
    "stretch_urdf": "--no-deps hello-robot-stretch-urdf",
}
"""Arguments of `pip install` that bring a package, by its name in `package://NAME/PATH`; those without
dependencies are used for their data alone.
"""
_MODULE = re.compile(r"[A-Za-z_]\w*")
_SHARES = ("share", "cmeel.prefix/share")
_DEPTH = 3  # folders below an entry of ROS_PACKAGE_PATH that are searched
_MAX_FOLDERS = 5000  # that are looked into below one entry


def package_folders(name: str) -> Iterator[Path]:
    """Yield the folders that a package may be in, those of Python packages first.

    The search covers Python packages; `share/NAME` under each entry of AMENT_PREFIX_PATH; packages under each
    entry of ROS_PACKAGE_PATH; and `share/NAME` of Python's own prefix and of each folder of Python packages,
    where packages of pip put their data.

    Args:
        name: name of the package.
    """
    if not PACKAGE_NAME.fullmatch(name):
        return
    found: list[Path] = []
    for folder in _candidates(name):
        if folder not in found and folder.is_dir():
            found.append(folder)
            yield folder


def package_of(file: Path) -> str | None:
    """Return a file's `package://NAME/PATH`, or None if it is in no package that can be found.

    Args:
        file: absolute path.
    """
    file = file.resolve()
    for folder in file.parents:
        if any(package_folder.resolve() == folder for package_folder in package_folders(folder.name)):
            return f"{PACKAGE_PREFIX}{folder.name}/{file.relative_to(folder).as_posix()}"
    return None


def _candidates(name: str) -> Iterator[Path]:
    yield from _python_package(name)
    for entry in _entries("AMENT_PREFIX_PATH"):
        yield entry / "share" / name
    for entry in _entries("ROS_PACKAGE_PATH"):
        yield entry / name  # as other readers of URDFs take it, also without a package.xml
        yield from (package for package in _ros_packages(entry) if package.name == name)
    for prefix in (sys.prefix, *sys.path):
        for share in _SHARES:
            yield Path(prefix or ".") / share / name


def _python_package(name: str) -> Iterator[Path]:
    if not _MODULE.fullmatch(name):
        return
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        return
    for folder in (spec.submodule_search_locations if spec is not None else None) or ():
        yield Path(folder)


def _entries(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]


@lru_cache(maxsize=32)
def _ros_packages(entry: Path) -> Sequence[Path]:
    """Return the folders with a `package.xml` at an entry of ROS_PACKAGE_PATH or a few levels below it."""
    found: list[Path] = []
    level, seen = [entry], 0
    for _ in range(_DEPTH + 1):
        below: list[Path] = []
        for folder in level:
            seen += 1
            if seen > _MAX_FOLDERS:
                return found
            if (folder / "package.xml").is_file():
                found.append(folder)
            else:
                below += _folders_in(folder)
        level = below
    return found


def _folders_in(folder: Path) -> list[Path]:
    try:
        return sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    except OSError:
        return []
