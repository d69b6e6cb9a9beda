"""`handcart list`: what there is."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

TASKS = Path(__file__).parent.parent.parent / "tasks"


class What(StrEnum):
    """What can be listed."""

    primitives = "primitives"
    backends = "backends"
    robots = "robots"
    tasks = "tasks"


def list_names(what: Annotated[What, typer.Argument(help="what to list")]) -> None:
    """List primitives, backends, robots or tasks, with one line about each."""
    rows = {
        What.primitives: _primitives,
        What.backends: _backends,
        What.robots: _robots,
        What.tasks: _tasks,
    }[what]()
    width = max((len(name) for name, _ in rows), default=0)
    for name, line in rows:
        print(f"{name:<{width}}  {line}".rstrip())


def _primitives() -> list[tuple[str, str]]:
    from handcart.primitives.registry import primitive_class, primitive_names

    return [(name, _first_line(name, primitive_class)) for name in primitive_names()]


def _first_line(name: str, find: Callable[[str], type]) -> str:
    """The first line of a class's docstring; somebody else's that can't be imported hides no others."""
    try:
        return (find(name).__doc__ or "").strip().split("\n")[0]
    except (ImportError, AttributeError) as error:
        return f"can't be imported: {error}"


def _backends() -> list[tuple[str, str]]:
    from handcart.backends.registry import backend_names

    return [(name, "") for name in backend_names()]


def _robots() -> list[tuple[str, str]]:
    from handcart.backends.description.robot_loading import robot_names, shipped_path

    return [(name, _first_comment(shipped_path(name))) for name in robot_names()]


def _first_comment(file: Path) -> str:
    first = file.read_text(encoding="utf-8").split("\n", 1)[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""


def _tasks() -> list[tuple[str, str]]:
    from handcart.files.yaml.yaml_document import read_document

    found = sorted(TASKS.glob("*/task.yaml"))
    return [(path.parent.name, str(read_document(path).data.get("title", ""))) for path in found]
