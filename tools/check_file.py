"""`handcart check`: everything that can be known about a file without moving."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from files.errors import InputError
    from networks.task_file import Task


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
        told.pop("lines", None)
        print(orjson.dumps({"ok": True, **told}).decode())
        return
    warnings = told.pop("warnings", ())
    print(f"{file}: no fault found{f', {len(warnings)} warnings' if warnings else ''}")
    for warning in warnings:
        print(f"  warning: {warning}")
    for line in told.pop("lines", ()):
        print(f"  {line}")
    told.pop("figures", None)
    for name, value in told.items():
        print(f"  {name}: {value}")


def check_quietly(file: Path) -> dict[str, Any]:
    """What `check` would print about a file; raises what it would tell."""
    return _facts(file, {})


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
    if kind == "table":
        return _table_facts(file)
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
    from networks.analysis.task_findings import task_findings
    from networks.run import prepare

    with prepare(file, settings=settings) as prepared:
        network = prepared.task.network
        return {
            "title": prepared.task.file.title,
            "situations": len(network.situations),
            "actions": len(network.actions),
            "longest run": f"at most {network.bound()} actions",
            "warnings": [*prepared.warnings, *map(str, task_findings(prepared.task))],
            **_task_figures(prepared.task),
        }


def _task_figures(task: Task) -> dict[str, Any]:
    """How runs end, where the file gives all probabilities."""
    from networks.analysis.figures import ASSUMPTION, figures, missing_chances
    from networks.analysis.forecast import TooLarge

    missing = missing_chances(task)
    if len(missing) == len(task.file.actions):
        return {}
    if missing:
        which = ", ".join(f"{number} ({task.file.actions[number].do})" for number in missing)
        return {"how runs end": f"not known: `p` is missing in the actions {which}"}
    try:
        found = figures(task)
    except TooLarge:
        return {"how runs end": "not known: there are too many states for exact figures"}
    now = found.forecast
    lines = [
        f"how runs end, if {ASSUMPTION}:",
        f"  P(goal) {now.goal:.5f}, no way left {now.no_way:.5f}, a person is needed {now.give_up:.5f}",
        f"  expected cost {now.cost_s:.1f} s, standard deviation {now.cost_sigma_s:.1f} s",
        "  P(goal) by P(Success) of an action, and what one more attempt of it would give:",
    ]
    lines += [
        f"    {each.words}: {each.slope:.4f}; {each.one_more.goal:.5f} at {each.one_more.cost_s:.1f} s"
        for each in found.influences
    ]
    return {"lines": lines, "figures": found.for_programs()}


def _table_facts(file: Path) -> dict[str, Any]:
    from files.loading import load_document
    from files.yaml_document import read_document
    from networks.analysis.absorbing_chain import NeverEnds
    from networks.analysis.action_table import ActionTable, table_absorption, table_findings

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
    warnings = [str(each) for each in table_findings(loaded)]
    return {"title": loaded.value.title, "warnings": warnings, "lines": lines, "figures": figures}
