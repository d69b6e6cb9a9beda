"""The kinds of files that users write."""

from __future__ import annotations

from inspect import isfunction
from pathlib import Path
from typing import Any

from handcart.tasks.domain import domains, imported

MAX_NEIGHBOUR_FILES = 20  # next to a URDF

_GENERAL = {
    "task": "handcart.networks.task.task_model:task_model",
    "robot": "handcart.backends.loading.robot_model:robot_model",
    "world": "handcart.backends.simulation.world_files.world_model:world_model",
    "table": "handcart.networks.analysis.action_table:ActionTable",
    "places": "handcart.primitives.knowledge.place:Places",
}


def kinds() -> dict[str, str]:
    """Return all kinds of files, each with the import path of the Pydantic model that validates files of that
    kind.

    A kind is the part of a file's key `format` after `handcart-`.
    """
    found = dict(_GENERAL)
    for domain in domains():
        found |= domain.files
    return found


def is_urdf(path: Path) -> bool:
    """Return whether a file is a URDF, by its suffix."""
    return path.suffix.lower() in (".urdf", ".xacro")


def robots_beside(urdf: Path) -> list[Path]:
    """Return the robot files in a URDF's folder that name this URDF."""
    from ruamel.yaml.error import YAMLError

    from handcart.files.errors import InputError
    from handcart.files.yaml.yaml_document import read_document

    found = []
    for path in sorted((*urdf.parent.glob("*.yaml"), *urdf.parent.glob("*.yml")))[:MAX_NEIGHBOUR_FILES]:
        try:
            data = read_document(path).data
        except (InputError, OSError, YAMLError):
            continue
        if isinstance(data, dict) and data.get("urdf") == urdf.name:
            found.append(path)
    return found


def model_of(kind: str) -> Any:
    """Return the pydantic model that files of a kind, such as a task's or a robot's, are checked with.

    Raises:
        KeyError: the kind is unknown.
    """
    found = imported(kinds()[kind])
    return found() if isfunction(found) else found
