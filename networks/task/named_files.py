"""Files and robots that a task names, and values set on the command line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from handcart.backends.description.robot_names import SHIPPED_FOLDER, find_robot, named_robots
from handcart.files.errors import UnsafePath
from handcart.files.inside import resolve_inside
from handcart.files.maps.map_file import map_path
from handcart.files.models.settings import SETTINGS_SECTION, setting_value, with_settings
from handcart.files.printable import printable
from handcart.files.suggest import suggest
from handcart.files.uninstalled import not_installed
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath

from .task_knowledge import PLACES_KIND, UNKNOWN_START, domain_keys, is_start_unknown
from .without_map import MAP_KEY, NO_MAP

SPEED_MASK_KEYS = ("knowledge", "speed_limits", "mask")
MAP_KEYS: tuple[KeyPath, ...] = (("world",), ("knowledge", "map"), ("knowledge", "keepout"), SPEED_MASK_KEYS)
"""Keys of files that may be maps, which may be in any folder."""


def resolved(document: Document, key: KeyPath) -> Path | None:
    """Return the path of the file that a task names under the path of keys `key`; None if it names none
    there.

    Raises:
        UnsafePath: the file is outside the folders that a task may use.
    """
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
    """Return the message that a file, which a task names, is missing."""
    folder = printable(str(path.parent.absolute()))
    return f"missing file {path.name!r} in {folder}; allowed: a file, from the task's folder"


def with_set(document: Document, settings: dict[str, str]) -> Document:
    """Return a task's document with the values of the command line's `--set KEY=VALUE` filled in.

    `robot` and `policy` may be set in any task; other keys only if the task has them as settings.
    """
    declared = document.root.deepest((*SETTINGS_SECTION, "robot"))[1]
    if "policy" in settings and not document.root.deepest((*SETTINGS_SECTION, "policy"))[1]:
        document = document.with_value(("policy",), setting_value("policy", settings.pop("policy")))
    if "robot" in settings and not declared and document.root.child("robot"):
        document = document.with_value(("robot",), setting_value("robot", settings.pop("robot")))
    return with_settings(document, settings) if settings else document


def named_robot(document: Document, name: str) -> str:
    """Return the robot that a task names, as the name of a shipped robot or the path of a robot's file."""
    if not name.endswith((".yaml", ".yml")) or (SHIPPED_FOLDER / name).exists():
        return name
    return str(resolved(document, ("robot",)))


def start_place_faults(document: Document, names: list[str] | None) -> Iterator[tuple[KeyPath, str]]:
    """Yield a fault if the task starts at a place that is not known.

    Args:
        document: the task.
        names: names of the places; None if they cannot be read.
    """
    key = ("knowledge", "start")
    node, there = document.root.deepest(key)
    name = node.content
    if is_start_unknown(document, names or ()):
        return
    if there and not document.root.deepest(("knowledge", "places"))[1]:
        yield key, "names a place; needed: the key `places`, a file with places"
    elif there and names is not None and isinstance(name, str) and name not in names:
        yield key, f"unknown place {name!r}{suggest(name, [*names, UNKNOWN_START])}"


def robot_faults(document: Document) -> Iterator[tuple[KeyPath, str]]:
    """Yield a fault if the task names a robot that is not known."""
    node, there = document.root.deepest(("robot",))
    name = node.content
    is_name = there and isinstance(name, str) and not name.endswith((".yaml", ".yml"))
    if is_name and isinstance(name, str) and find_robot(name) is None:
        allowed = suggest(name, named_robots())
        hint = not_installed(document.file)
        yield ("robot",), f"unknown robot {name!r}{allowed}, or the path of a robot's YAML file{hint}"


def file_faults(document: Document) -> Iterator[tuple[KeyPath, str]]:
    """Yield a fault for each file that the task names and that is missing or may not be read."""
    named = [("knowledge", name) for name in ("map", "keepout", PLACES_KIND, *domain_keys())]
    for key in (("world",), *named, SPEED_MASK_KEYS):
        try:
            path = resolved(document, key)
        except UnsafePath as unsafe:
            yield key, str(unsafe)
            continue
        if path is not None and not path.is_file():
            yield key, no_file(path)
