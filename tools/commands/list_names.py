"""`handcart list`: names of primitives, causes, backends, robots and tasks."""

from __future__ import annotations

import sys
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class What(StrEnum):
    """Kind of names that `handcart list` prints."""

    primitives = "primitives"
    causes = "causes"
    backends = "backends"
    robots = "robots"
    tasks = "tasks"


def list_names(
    what: Annotated[What, typer.Argument(help="what to list")],
    table: Annotated[
        bool, typer.Option("--table", help="of robots: which primitives each can do, on which backends")
    ] = False,
) -> None:
    """List primitives, causes of their Fails, backends, robots or tasks, with one line about each."""
    if table:
        _robot_table(what)
        return
    rows = {
        What.primitives: _primitives,
        What.causes: _causes,
        What.backends: _backends,
        What.robots: _robots,
        What.tasks: _tasks,
    }[what]()
    for broken in _broken(what):
        print(broken, file=sys.stderr)
    width = max((len(name) for name, _ in rows), default=0)
    for name, line in rows:
        print(f"{name:<{width}}  {line}".rstrip())


def _robot_table(what: What) -> None:
    """Print the table of robots, row by row: each row reads the URDF of a robot."""
    from handcart.tools.checks.robot_table import robot_table

    if what is not What.robots:
        raise typer.BadParameter("--table is for robots; allowed: handcart list robots --table")
    from handcart.backends.description.robot_names import named_robots

    wide = max(map(len, named_robots()))
    for row in robot_table():
        print(row.line(wide), flush=True)


def _broken(what: What) -> list[str]:
    """Return what cannot be listed because another package's entry point names nothing."""
    from handcart.files.plugins import broken_plugin_folders

    return broken_plugin_folders(f"handcart.{what}") if what in (What.robots, What.tasks) else []


def _primitives() -> list[tuple[str, str]]:
    from handcart.primitives.registry import primitive_class, primitive_names

    return [(name, _first_line(name, primitive_class)) for name in primitive_names()]


def _causes() -> list[tuple[str, str]]:
    """Return all causes with their texts, and the primitives that can raise them."""
    from handcart.primitives.contract.raised_causes import causes_of, framework_causes
    from handcart.primitives.registry import primitive_class, primitive_names

    raised = {cause: ["any primitive"] for cause in framework_causes()}
    for name in primitive_names():
        try:
            own = causes_of(primitive_class(name))
        except (ImportError, AttributeError):  # `list primitives` says why it cannot be imported
            continue
        for cause in own:
            raised.setdefault(cause, []).append(name)
    return [(cause.name, f"{cause.text} ({', '.join(raised[cause])})") for cause in sorted(raised)]


def _first_line(name: str, find: Callable[[str], type]) -> str:
    """Return the first line of a class's docstring, or why the class cannot be imported."""
    try:
        return (find(name).__doc__ or "").strip().split("\n")[0]
    except (ImportError, AttributeError) as error:
        return f"can't be imported: {error}"


def _backends() -> list[tuple[str, str]]:
    from handcart.backends.registry import backend_names

    return [(name, "") for name in backend_names()]


def _robots() -> list[tuple[str, str]]:
    from handcart.backends.description.robot_names import named_robots

    return [(name, _first_comment(path)) for name, path in named_robots().items()]


def _first_comment(file: Path) -> str:
    first = file.read_text(encoding="utf-8").split("\n", 1)[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""


def _tasks() -> list[tuple[str, str]]:
    from handcart.tasks.task_names import named_tasks

    return [(name, _title(path)) for name, path in named_tasks().items()]


def _title(task: Path) -> str:
    """Return a task's title; a broken file hides no others."""
    from handcart.files.errors import FileError
    from handcart.files.yaml.yaml_document import read_document
    from handcart.networks.task.task_model import MAX_TASK_BYTES, MAX_TASK_NODES

    try:
        data = read_document(task, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES).data
    except FileError as error:
        return f"cannot be read: {error}"
    return str(data.get("title", "")) if isinstance(data, dict) else ""
