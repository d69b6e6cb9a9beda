"""Packages beside a file that declare plugins and are not installed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from handcart.files.errors import HandcartError
from handcart.files.plugins import entry_points_of
from handcart.files.regular_file import read_regular_file
from handcart.files.shown_path import shown_path

MAX_PROJECT_BYTES = 1 << 20
GROUP_PREFIX = "handcart."


def not_installed(path: Path | str) -> str:
    """Return what to append to a message about a name that no installed package has.

    It names the nearest folder above a file whose `pyproject.toml` declares plugins of handcart, if one of
    them is not installed; otherwise it is empty.

    Args:
        path: file that uses the name.
    """
    for folder in Path(path).resolve().parents:
        if declared := list(_declared(folder / "pyproject.toml")):
            missing = [f"{group}: {name}" for group, name in declared if not _is_installed(group, name)]
            if not missing:
                return ""
            how = f"pip install -e {shown_path(folder)}"
            return f"; {shown_path(folder)} declares plugins that are not installed ({missing[0]}): {how}"
    return ""


def _declared(path: Path) -> Iterator[tuple[str, str]]:
    """Yield group and name of each plugin of handcart that a project file declares."""
    if not path.is_file():
        return
    try:
        content: Any = tomllib.loads(read_regular_file(path, MAX_PROJECT_BYTES).decode())
        groups = content.get("project", {}).get("entry-points", {})
        for group, points in groups.items():
            if group.startswith(GROUP_PREFIX):
                yield from ((group, name) for name in points)
    except (HandcartError, ValueError, AttributeError):  # no such file, or not one that a tool would read
        return


def _is_installed(group: str, name: str) -> bool:
    return any(point.name == name for point in entry_points_of(group))
