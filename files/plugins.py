"""What other packages bring, by their entry points."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def entry_points_of(group: str) -> list[EntryPoint]:
    """Those of a group that the installed packages name, by their names.

    The standard library reads every package's, and takes longer to import than all of `handcart --help`: it
    is asked only where a package has the group at all.
    """
    if not any(_may_have(folder or ".", f"[{group}]") for folder in sys.path):
        return []
    from importlib.metadata import entry_points

    return sorted(entry_points(group=group), key=lambda each: each.name)


def plugin_folders(group: str) -> dict[str, Path]:
    """Return the folders of the packages that an entry-point group names, by entry-point name.

    The value of such an entry point is an importable package. A dotted name imports its parents, the package
    itself is only located. A package that cannot be located is skipped: `broken_plugin_folders` names it.
    """
    found = ((point.name, _package_folder(point)) for point in entry_points_of(group))
    return {name: folder for name, folder in found if folder is not None}


def broken_plugin_folders(group: str) -> list[str]:
    """Return a message for each entry point of a group whose package cannot be located."""
    return [
        f"the entry point {point.name!r} of {group} names the package {point.value!r}, which cannot be found"
        for point in entry_points_of(group)
        if _package_folder(point) is None
    ]


def _package_folder(point: EntryPoint) -> Path | None:
    from importlib.util import find_spec

    try:
        spec = find_spec(point.value)
    except (ImportError, ValueError, AttributeError):
        return None
    places = list(spec.submodule_search_locations or ()) if spec else []
    return Path(places[0]) if places else None


def _may_have(folder: str, section: str) -> bool:
    """Whether an entry of Python's path may hold a package with that section; of archives nobody knows."""
    try:
        names = os.listdir(folder)
    except NotADirectoryError:
        return True
    except OSError:
        return False
    infos = (name for name in names if name.endswith((".dist-info", ".egg-info")) or name == "EGG-INFO")
    return any(section in _text(Path(folder, name, "entry_points.txt")) for name in infos)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
