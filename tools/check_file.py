"""`handcart check`: everything that can be known about a file without moving."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Iterable

    from files.errors import Finding, InputError


def check(
    file: Annotated[Path, typer.Argument(help="a task, robot, world, map, places or catalogue file")],
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="draw a robot, from the side and from above, into this file")
    ] = None,
) -> None:
    """Read a file with all that it names, and tell what is wrong with it: each finding with its place."""
    import orjson

    from files.errors import InputError
    from files.settings import split_setting

    try:
        told = _facts(file, dict(split_setting(each) for each in settings or []), picture)
    except InputError as error:
        if not as_json:
            raise
        print(orjson.dumps({"ok": False, "findings": _findings(error)}).decode())
        sys.exit(error.exit_status)
    errors = told.pop("errors", [])
    if as_json:
        told.pop("lines", None)
        found = {"findings": _places(errors)} if errors else {}
        print(orjson.dumps({"ok": not errors, **found, **told}).decode())
        sys.exit(InputError.exit_status if errors else 0)
    warnings = told.pop("warnings", ())
    for each in errors:
        print(each, file=sys.stderr)
    faults = f"{len(errors)} faults" if errors else "no fault found"
    print(f"{file}: {faults}{f', {len(warnings)} warnings' if warnings else ''}")
    for warning in warnings:
        print(f"  warning: {warning}")
    for line in told.pop("lines", ()):
        print(f"  {line}")
    for key in ("figures", "robot", "short", "places"):
        told.pop(key, None)
    for name, value in told.items():
        print(f"  {name}: {value}")
    sys.exit(InputError.exit_status if errors else 0)


def check_quietly(file: Path) -> dict[str, Any]:
    """What `check` would print about a file; raises what it would tell."""
    return _facts(file, {}, quick=True)


def _findings(error: InputError) -> list[dict[str, Any]]:
    from files.errors import FileError

    if not isinstance(error, FileError):  # a name that no file's line is known for
        return [{"file": None, "line": 0, "column": 0, "message": str(error)}]
    return _places(error.findings)


def _places(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    return [
        {"file": each.file, "line": each.line, "column": each.column, "message": each.message}
        for each in findings
    ]


def _facts(
    file: Path, settings: dict[str, str], picture: Path | None = None, quick: bool = False
) -> dict[str, Any]:
    from backends.map_file import is_map_file
    from files.errors import FileError
    from files.loading import load
    from files.suggest import suggest
    from files.yaml_document import read_document
    from primitives.ros_goals import is_goals

    from .file_kinds import KINDS, model_of

    if is_map_file(file):
        return _map_facts(file)
    document = read_document(file)
    if is_goals(document):
        return _goals_facts(file)
    data = document.data if isinstance(document.data, dict) else {}
    kind = str(data.get("format", "")).removeprefix("handcart-").split("/")[0]
    if kind not in KINDS:
        allowed = [f"handcart-{each}/1" for each in KINDS]
        wrong = f"the key 'format' doesn't tell what this is{suggest(str(data.get('format', '')), allowed)}"
        raise FileError([document.finding(("format",) if "format" in data else (), wrong)])
    if kind == "task":
        return _task_facts(file, settings, quick)
    if kind == "table":
        return _table_facts(file)
    if kind == "robot":
        from .check_robot import robot_facts

        return robot_facts(file, picture, quick)
    if kind == "world":
        from backends.scene.load_world import load_world

        load_world(file)
    else:
        load(file, model_of(kind))
    return {"format": data["format"]}


def _map_facts(file: Path) -> dict[str, Any]:
    from backends.map_file import load_map
    from backends.movingai_map import SUFFIX

    grid, warning = load_map(file)
    height, width = grid.occupied.shape
    counts = {"occupied": int(grid.occupied.sum()), "unknown": int(grid.unknown.sum())}
    size = f"{width} x {height} of {grid.resolution:g} m"
    kind = "MovingAI map" if file.suffix == SUFFIX else "ROS map"
    return {"format": kind, "cells": size, **counts, "warnings": [warning] if warning else []}


def _goals_facts(file: Path) -> dict[str, Any]:
    from primitives.place_file import load_places

    return {"format": "goals for nav2", "places": list(load_places(file).value.places)}


def _task_facts(file: Path, settings: dict[str, str], quick: bool) -> dict[str, Any]:
    from backends.robot_file import load_robot
    from evaluation.robot_report.posture_findings import posture_findings
    from evaluation.seam_check import seam_facts
    from networks.preparing import check as check_task

    from .check_task import task_facts

    checked = check_task(file, settings=settings)
    told = task_facts(checked.task) | ({} if quick else seam_facts(checked.task))
    robot = checked.task.robot
    postures = map(str, posture_findings(robot, load_robot(robot)))
    lines = [*(each.words() for each in checked.places), *told.get("lines", ())]
    places = {"places": [each.for_programs() for each in checked.places]} if checked.places else {}
    told |= {"lines": lines, "warnings": [*checked.warnings, *postures, *told["warnings"]]}
    return {**told, **places, "errors": list(checked.errors)}


def _table_facts(file: Path) -> dict[str, Any]:
    from files.loading import load_document
    from files.yaml_document import read_document
    from networks.analysis.absorbing_chain import NeverEnds
    from networks.analysis.action_table import ActionTable, table_absorption, table_errors, table_warnings

    loaded = load_document(read_document(file), ActionTable)
    lines, figures = [], {}
    for p in (0.8, 0.9, 0.99):
        try:
            ends, steps, sigma = table_absorption(loaded.value, p)
        except NeverEnds:
            lines = ["how runs end: some never do"]
            break
        shares = ", ".join(f"{name} {share:.5f}" for name, share in sorted(ends.items()))
        lines.append(
            f"if each succeeds with {p}, independently: {shares}; {steps:.4f} ± {sigma:.4f} primitives"
        )
        figures[str(p)] = {"ends": ends, "steps": steps, "steps_sigma": sigma}
    warnings = [str(each) for each in table_warnings(loaded)]
    told = {"title": loaded.value.title, "warnings": warnings, "errors": table_errors(loaded)}
    return {**told, "lines": lines, "figures": figures}
