"""`handcart check`: everything that can be known about a file without moving."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from files.errors import InputError


def check(
    file: Annotated[Path, typer.Argument(help="a task, robot, world, map, places or catalogue file")],
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
) -> None:
    """Read a file with all that it names, and tell what is wrong with it: each finding with its place."""
    import orjson

    from files.errors import InputError
    from files.settings import split_setting

    try:
        told = _facts(file, dict(split_setting(each) for each in settings or []))
    except InputError as error:
        if not as_json:
            raise
        print(orjson.dumps({"ok": False, "findings": _findings(error)}).decode())
        sys.exit(error.exit_status)
    if as_json:
        print(orjson.dumps({"ok": True, **told}).decode())
        return
    print(f"{file}: no fault found")
    for warning in told.pop("warnings", ()):
        print(f"  warning: {warning}")
    for name, value in told.items():
        print(f"  {name}: {value}")


def _findings(error: InputError) -> list[dict[str, Any]]:
    from files.errors import FileError

    if not isinstance(error, FileError):  # a name that no file's line is known for
        return [{"file": None, "line": 0, "column": 0, "message": str(error)}]
    return [
        {"file": each.file, "line": each.line, "column": each.column, "message": each.message}
        for each in error.findings
    ]


def _facts(file: Path, settings: dict[str, str]) -> dict[str, Any]:
    from backends.map_file import is_map
    from files.errors import FileError
    from files.loading import load
    from files.suggest import suggest
    from files.yaml_document import read_document

    from .file_kinds import KINDS, model_of

    document = read_document(file)
    if is_map(document):
        return _map_facts(file)
    data = document.data if isinstance(document.data, dict) else {}
    kind = str(data.get("format", "")).removeprefix("handcart-").split("/")[0]
    if kind not in KINDS:
        allowed = [f"handcart-{each}/1" for each in KINDS]
        wrong = f"the key 'format' doesn't tell what this is{suggest(str(data.get('format', '')), allowed)}"
        raise FileError([document.finding(("format",) if "format" in data else (), wrong)])
    if kind == "task":
        return _task_facts(file, settings)
    if kind == "robot":
        from backends.robot_file import load_robot

        robot = load_robot(str(file))
        return {"format": data["format"], "joints": len(robot.arm.joints) if robot.arm else 0}
    if kind == "world":
        from backends.scene.load_world import load_world

        load_world(file)
    else:
        load(file, model_of(kind))
    return {"format": data["format"]}


def _map_facts(file: Path) -> dict[str, Any]:
    from backends.map_file import load_map

    grid, warning = load_map(file)
    height, width = grid.occupied.shape
    counts = {"occupied": int(grid.occupied.sum()), "unknown": int(grid.unknown.sum())}
    size = f"{width} x {height} of {grid.resolution:g} m"
    return {"format": "ROS map", "cells": size, **counts, "warnings": [warning] if warning else []}


def _task_facts(file: Path, settings: dict[str, str]) -> dict[str, Any]:
    from networks.run import prepare

    with prepare(file, settings=settings) as prepared:
        network = prepared.task.network
        return {
            "title": prepared.task.file.title,
            "situations": len(network.situations),
            "actions": len(network.actions),
            "longest run": f"at most {network.bound()} actions",
            "warnings": list(prepared.warnings),
        }
