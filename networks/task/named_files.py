"""Files and robots that a task names, and values set on the command line."""

from __future__ import annotations

from pathlib import Path

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.files.inside import resolve_inside
from handcart.files.maps.map_file import map_path
from handcart.files.models.settings import SETTINGS_SECTION, setting_value, with_settings
from handcart.files.printable import printable
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath

from .without_map import MAP_KEY, NO_MAP

SPEED_MASK_KEYS = ("knowledge", "speed_limits", "mask")
MAP_KEYS: tuple[KeyPath, ...] = (("world",), ("knowledge", "map"), ("knowledge", "keepout"), SPEED_MASK_KEYS)
"""Keys of files that may be maps, which may be in any folder."""


def resolved(document: Document, key: KeyPath) -> Path | None:
    """Return the path of a file that a task names; None if it names none."""
    node, there = document.root.deepest(key)
    if not there or not isinstance(node.content, str) or (key == MAP_KEY and node.content == NO_MAP):
        return None
    if node.line == 0:  # from the command line: the user's own words
        return Path(node.content)
    folder = document.folder.resolve()
    # Neighbouring tasks may share a world.
    find = map_path if key in MAP_KEYS else resolve_inside
    return find(folder.parent, node.content, start=folder)


def no_file(path: Path) -> str:
    """Return that a named file is missing, in words."""
    folder = printable(str(path.parent.absolute()))
    return f"there is no file {path.name!r} in {folder}; allowed: a file, from the task's folder"


def with_set(document: Document, settings: dict[str, str]) -> Document:
    """Return a task with the values of `--set KEY=VALUE`; `robot` and `policy` may be set in any task."""
    declared = document.root.deepest((*SETTINGS_SECTION, "robot"))[1]
    if "policy" in settings and not document.root.deepest((*SETTINGS_SECTION, "policy"))[1]:
        document = document.with_value(("policy",), setting_value("policy", settings.pop("policy")))
    if "robot" in settings and not declared and document.root.child("robot"):
        document = document.with_value(("robot",), setting_value("robot", settings.pop("robot")))
    return with_settings(document, settings) if settings else document


def named_robot(document: Document, name: str) -> str:
    """Return the name of a shipped robot, or the path of a robot's file that a task names."""
    if not name.endswith((".yaml", ".yml")) or (SHIPPED_FOLDER / name).exists():
        return name
    return str(resolved(document, ("robot",)))
