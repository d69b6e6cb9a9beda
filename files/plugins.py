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
