"""Tasks by name: the shipped ones, and those of other packages.

A package adds its tasks by an entry point of the group `handcart.tasks`. The entry point names a package;
each folder in it that holds a `task.yaml` is a task called ENTRY_POINT/FOLDER.
"""

from __future__ import annotations

from pathlib import Path

from handcart.files.errors import FileError, Finding
from handcart.files.plugins import plugin_folders
from handcart.files.suggest import suggest

TASKS_GROUP = "handcart.tasks"
TASK_FILE = "task.yaml"
SHIPPED_FOLDER = Path(__file__).parent


def named_tasks() -> dict[str, Path]:
    """Return the paths of all tasks that can be run by name, keyed by the name; the shipped ones come
    first.
    """
    tasks = _tasks_below(SHIPPED_FOLDER, "")
    for owner, folder in plugin_folders(TASKS_GROUP).items():
        tasks |= _tasks_below(folder, f"{owner}/")
    return tasks


def task_path(given: Path | str) -> Path:
    """Return the task file for a path or the name of a task; an existing file at the path is preferred.

    Raises:
        FileError: the argument is neither a path nor the name of a task.
    """
    path = Path(given)
    if path.suffix or path.is_absolute() or _exists(path):
        return path
    name = path.as_posix()
    tasks = _tasks_below(SHIPPED_FOLDER, "")
    if name not in tasks:
        tasks = named_tasks()
    if name not in tasks:
        raise FileError([_unknown(name, tasks)])
    return tasks[name]


def _tasks_below(folder: Path, prefix: str) -> dict[str, Path]:
    return {f"{prefix}{path.parent.name}": path for path in sorted(folder.glob(f"*/{TASK_FILE}"))}


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, or with a null byte: the reader of the file reports it
        return True


def _unknown(name: str, tasks: dict[str, Path]) -> Finding:
    allowed = f"{suggest(name, tasks)}, or the path of a task file"
    return Finding(name, 0, 0, f"no such file, and no task has this name{allowed}")
