"""Writing of tasks in formats of other programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from handcart.files.errors import InputError
from handcart.networks.task.task_file import Task

from .bt_export import tree_text
from .jani import model_text
from .scxml import chart_text
from .task_parts import TaskParts

FORMAT_WRITERS: Mapping[str, tuple[Callable[[TaskParts], str], str]] = {
    "bt": (tree_text, ".xml"),
    "scxml": (chart_text, ".scxml"),
    "jani": (model_text, ".jani"),
}
"""Writers and suffixes of the formats, by their names."""


class NotExpressed(InputError):
    """Error for a task that a format of another program cannot express; the message says why."""


def exported(task: Task, kind: str) -> tuple[str, tuple[str, ...]]:
    """Return a task as text in another program's format, and the parts that have no effect there.

    Args:
        task: the task.
        kind: name of the format.

    Raises:
        NotExpressed: a name cannot be written in the format.
    """
    parts = TaskParts.of_task(task)
    try:
        return FORMAT_WRITERS[kind][0](parts), tuple(parts.lost())
    except ValueError as error:
        raise NotExpressed(str(error)) from None
