"""Reading of any known format as a task, by the content of the file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from handcart.files.errors import FileError, Finding

from .bt_export import changed_leaves, is_own_tree, parts_of_tree
from .bt_import import import_tree
from .jani import import_model
from .lost import Imported
from .pddl_import import import_planning
from .scxml import is_own_chart, parts_of_chart
from .smach_import import import_smach
from .task_parts import TaskParts
from .xml_tree import XmlElement, read_xml_tree

FORMAT_SUFFIXES = {
    ".xml": "BehaviorTree.CPP",
    ".scxml": "SCXML, as `handcart export` writes it",
    ".jani": "JANI",
    ".pddl": "PDDL, PPDDL",
    ".ppddl": "PPDDL",
    ".yaml": "SMACH",
    ".yml": "SMACH",
}
"""Formats by their suffixes."""


def import_file(path: Path, problem: Path | None = None) -> Imported:
    """Convert a file of another program, in the format that its suffix or content shows, to a task.

    Args:
        path: the file.
        problem: a file with the problem of a PDDL domain; None: the problem is in `path` as well.

    Raises:
        FileError: the file is of no known format, or not well-formed.
        TooLargeDraft: the retries in the file multiply to too many actions.
    """
    suffix = path.suffix.lower()
    if suffix in (".yaml", ".yml"):
        return import_smach(path)
    if suffix in (".pddl", ".ppddl"):
        return import_planning(path, problem)
    if suffix == ".jani":
        return import_model(path)
    if suffix not in (".xml", ".scxml"):
        allowed = ", ".join(f"*{key} ({name})" for key, name in FORMAT_SUFFIXES.items())
        raise FileError([Finding(str(path), 0, 0, f"unknown format {suffix!r}; allowed: {allowed}")])
    root = read_xml_tree(path)
    if root.tag == "scxml":
        return _chart(path, root)
    return _own_tree(path, root) if is_own_tree(root) else import_tree(path)


def _chart(path: Path, root: XmlElement) -> Imported:
    if not is_own_chart(root):
        wrong = "a state chart of another program"
        allowed = "allowed: one that `handcart export` wrote"
        raise FileError([Finding(str(path), root.line, root.column, f"{wrong}; {allowed}")])
    try:
        return Imported(parts_of_chart(root).data(), ())
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise _changed(path, root, error) from None


def _own_tree(path: Path, root: XmlElement) -> Imported:
    try:
        parts: TaskParts = parts_of_tree(root)
        return Imported(parts.data(), tuple(changed_leaves(root)))
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise _changed(path, root, error) from None


def _changed(path: Path, root: XmlElement, error: Exception) -> FileError:
    wrong = f"it was written from a task, and is none any more: {type(error).__name__}: {error}"
    allowed = "allowed: other situations, parameters and numbers, in the same places"
    return FileError([Finding(str(path), root.line, root.column, f"{wrong}; {allowed}")])


def primitives_in(imported: Imported) -> Iterator[str]:
    """Yield the names of the primitives that a task names, each once."""
    yield from dict.fromkeys(str(action["do"]) for action in imported.data["actions"])
