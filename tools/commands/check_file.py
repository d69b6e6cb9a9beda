"""`handcart check`: all checks of a file that need no motion."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from handcart.files.printable import counted
from handcart.files.shown_path import shown_path
from handcart.files.stages import begin_stage
from handcart.networks.chains.few_collections import few_collections

if TYPE_CHECKING:
    from collections.abc import Iterable

    from handcart.files.errors import FileError, Finding, InputError
    from handcart.files.yaml.yaml_document import Document
    from handcart.networks.task.task_file import Task

PolicyName = Literal["rule", "expected_cost", "goal_probability"]
MAX_FINDING_LINES = 12  # more are grouped by kind


class CheckOptions(NamedTuple):
    """Options of `handcart check`, as given on the command line, that select additional checks and
    outputs.
    """

    picture: Path | None = None
    every: bool = False
    """True to list each joint, link and mesh of a robot."""
    allow: bool = False
    """True to write pairs that always touch into the robot's file."""
    draft: Path | None = None
    """Path of a robot's file to write for a URDF."""
    quick: bool = False
    """True to skip checks that take seconds."""
    backend: str | None = None
    """Name of a simulated backend to build with a robot."""

    def given(self, settings: Iterable[str]) -> list[str]:
        """Return the options that concern one kind of file and were given, such as `--picture`.

        Args:
            settings: names of the settings; `policy` is one of its own option.
        """
        by_name = {
            "--set": any(name != "policy" for name in settings),
            "--policy": "policy" in settings,
            "--picture": self.picture is not None,
            "--allow": self.allow,
            "--backend": self.backend is not None,
            "--draft": self.draft is not None,
        }
        return [name for name, is_given in by_name.items() if is_given]


def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="a file (task, robot, world, map, places ...), a URDF, or a task's or robot's name"
        ),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
    policy: Annotated[PolicyName | None, typer.Option(help="of a task: another policy than it names")] = None,
    picture: Annotated[
        Path | None, typer.Option(help="draw a robot, from the side and from above, into this file")
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="of a robot: each joint, link and mesh")] = False,
    allow: Annotated[
        bool, typer.Option("--allow", help="write pairs of links that always touch into the robot's file")
    ] = False,
    draft: Annotated[
        Path | None, typer.Option(help="write a first robot's file for a URDF, beside it or above")
    ] = None,
    backend: Annotated[
        str | None, typer.Option(help="of a robot: build this simulated backend with it, such as mujoco")
    ] = None,
    ros2: Annotated[
        bool, typer.Option("--ros2", help="of a robot: compare its file with the topics that are on the air")
    ] = False,
    bench: Annotated[
        str | None, typer.Option(help="with --ros2: topics of this simulated backend in this process")
    ] = None,
    bag: Annotated[
        Path | None, typer.Option(help="with --ros2: topics of this recorded bag (rosbag2, rosbag1)")
    ] = None,
    seconds: Annotated[float | None, typer.Option(min=0.5, help="with --ros2: listen so long (5 s)")] = None,
) -> None:
    """Check a file and all files that it names, and report each finding with its place."""
    import orjson

    from handcart.files.errors import FileError, InputError
    from handcart.files.models.settings import split_settings
    from handcart.tools.checks.check_air import LISTENING_S, air_facts
    from handcart.tools.checks.option_kinds import refuse_other_topics
    from handcart.tools.terminal.first_use import announced

    try:
        given = split_settings([*(settings or []), *([f"policy={policy}"] if policy else [])])
        with announced(f"checking {shown_path(file)}"):
            options = CheckOptions(picture, every, allow, draft, backend=backend)
            alone = {"--bag": bag, "--bench": bench, "--seconds": seconds}
            refuse_other_topics(ros2, alone, options.given(given))
            facts = (
                air_facts(str(file), bench, seconds or LISTENING_S, bag)
                if ros2
                else file_facts(file, given, options)
            )
    except InputError as error:
        if not as_json:
            if isinstance(error, FileError) and not every:
                _tell_grouped(error)
            raise
        print(orjson.dumps({"ok": False, "findings": _findings(error)}).decode())
        sys.exit(error.exit_status)
    errors = facts.pop("errors", [])
    if as_json:
        facts.pop("lines", None)
        facts.pop("grouped", None)
        found = {"findings": _places(errors)} if errors else {}
        print(orjson.dumps({"ok": not errors, **found, **facts}).decode())
        sys.exit(InputError.exit_status if errors else 0)
    warnings = facts.pop("warnings", ())
    for item in errors:
        print(item, file=sys.stderr)
    faults = counted(len(errors), "fault") if errors else "no fault found"
    also = f", {counted(len(warnings), 'warning')}" if warnings else ""
    print(f"{shown_path(file)}: {faults}{also}")
    grouped = facts.pop("grouped", warnings)
    for warning in warnings if every else grouped:
        print(f"  warning: {warning}")
    for line in facts.pop("lines", ()):
        print(f"  {line}")
    for key in ("figures", "policies", "robot", "short", "places", "computed_places"):
        facts.pop(key, None)
    for name, value in facts.items():
        print(f"  {name}: {value}")
    sys.exit(InputError.exit_status if errors else 0)


def check_quietly(file: Path) -> dict[str, Any]:
    """Check a file without the checks that take seconds, and return the file's properties for JSON.

    It raises the errors that `check` would report.
    """
    return file_facts(file, {}, CheckOptions(quick=True))


def _tell_grouped(error: FileError) -> None:
    """Print a line for each kind of fault and exit, if the file has many faults."""
    from handcart.evaluation.robot_report.remark import grouped_findings

    lines = grouped_findings(error.findings)
    if len(error.findings) <= MAX_FINDING_LINES:
        return
    for line in lines[:MAX_FINDING_LINES]:
        print(line, file=sys.stderr)
    if len(lines) > MAX_FINDING_LINES:
        print(
            f"and {counted(len(lines) - MAX_FINDING_LINES, 'more kind')} of faults; --all shows them",
            file=sys.stderr,
        )
    sys.exit(error.exit_status)


def _named_file(file: Path) -> Path:
    """Return the file of a task's or a robot's name; a path is returned unchanged."""
    from handcart.backends.description.robot_names import find_robot
    from handcart.files.errors import FileError
    from handcart.tasks.task_names import task_path

    try:
        return task_path(file)
    except FileError:
        robot = find_robot(file.as_posix())
        if robot is None:
            raise
        return robot


def _findings(error: InputError) -> list[dict[str, Any]]:
    from handcart.files.errors import FileError

    if not isinstance(error, FileError):  # a name that no file's line is known for
        return [{"file": None, "line": 0, "column": 0, "message": str(error)}]
    return _places(error.findings)


def _places(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    return [
        {"file": finding.file, "line": finding.line, "column": finding.column, "message": finding.message}
        for finding in findings
    ]


def file_facts(file: Path, settings: dict[str, str], asked: CheckOptions = CheckOptions()) -> dict[str, Any]:
    """Check a file and return its properties and findings.

    The result has the fields of `handcart check --json`, and in addition `lines` and `warnings` as text, and
    the faults of the task's places (`errors`).

    Args:
        file: path of the file, or the name of a task or robot.
        settings: unparsed parameters of a task, by name.
        asked: options of the command.

    Raises:
        FileError: the file has faults; the error contains all of them.
        InputError: the arguments name something that does not exist.
    """
    from handcart.files.errors import FileError
    from handcart.networks.task.hidden_faults import with_hidden

    file = _named_file(file)
    try:
        return _file_facts(file, settings, asked)
    except FileError as error:
        readings = [lambda: _file_facts(file, settings, CheckOptions(quick=True))]
        raise with_hidden(error, lambda: iter(readings)) from None


def _file_facts(file: Path, settings: dict[str, str], asked: CheckOptions) -> dict[str, Any]:
    """Return the facts of a file by its kind."""
    from handcart.files.maps.map_file import is_map
    from handcart.files.maps.movingai_map import MOVINGAI_SUFFIX
    from handcart.files.models.loading import load
    from handcart.files.yaml.yaml_document import read_document
    from handcart.networks.task.task_model import MAX_TASK_BYTES, MAX_TASK_NODES
    from handcart.primitives.knowledge.place import is_goals
    from handcart.tools.checks.file_kinds import is_urdf, kinds, model_of
    from handcart.tools.checks.option_kinds import refuse_other_options

    given = asked.given(settings)
    if is_urdf(file):
        refuse_other_options(given, "a URDF", shown_path(file))
        from handcart.tools.checks.check_urdf import urdf_facts

        return urdf_facts(file, asked.every, asked.draft)
    if file.suffix == MOVINGAI_SUFFIX:
        refuse_other_options(given, "a map", shown_path(file))
        return _map_facts(file)
    document = read_document(file, max_bytes=MAX_TASK_BYTES, max_nodes=MAX_TASK_NODES)
    if is_map(document):
        refuse_other_options(given, "a map", shown_path(file))
        return _map_facts(file)
    if is_goals(document):
        refuse_other_options(given, "a file of goals", shown_path(file))
        return _goals_facts(file)
    data = document.data if isinstance(document.data, dict) else {}
    kind = str(data.get("format", "")).removeprefix("handcart-").split("/")[0]
    if kind not in kinds():
        raise _unknown_kind(document)
    words = "a robot's file" if kind == "robot" else f"a {kind}"
    refuse_other_options(given, words, shown_path(file))
    if kind == "task":
        if not asked.quick:
            _import_domain_checks(data.get("knowledge"))
        return _task_facts(file, settings, asked.quick)
    if kind == "table":
        return _table_facts(file)
    if kind == "robot":
        return _robot_facts(file, asked)
    if kind == "world":
        from handcart.backends.simulation.world_files.load_world import load_world

        load_world(file)
    else:
        load(file, model_of(kind))
    return {"format": data["format"]}


def _robot_facts(file: Path, asked: CheckOptions) -> dict[str, Any]:
    from handcart.tools.checks.check_robot import robot_facts

    if asked.allow:
        from handcart.tools.checks.allowing import allow_contacts

        allow_contacts(file)
    return robot_facts(file, asked.picture, asked.quick, asked.every, asked.backend)


def _unknown_kind(document: Document) -> FileError:
    """Return the error that `format` is missing, misspelled, or names no kind of file."""
    from handcart.files.errors import FileError
    from handcart.files.suggest import nearest, suggest
    from handcart.tools.checks.file_kinds import kinds

    data = document.data if isinstance(document.data, dict) else {}
    misspelled = None if "format" in data else nearest("format", data)
    if misspelled is not None:
        wrong = f"unknown key {misspelled!r}; did you mean 'format'?"
        return FileError([document.finding((misspelled,), wrong, at_key=True)])
    allowed = [f"handcart-{item}/1" for item in kinds()]
    wrong = f"the key 'format' doesn't name a kind of file{suggest(str(data.get('format', '')), allowed)}"
    return FileError([document.finding(("format",) if "format" in data else (), wrong)])


def _map_facts(file: Path) -> dict[str, Any]:
    from handcart.files.maps.map_file import load_map
    from handcart.files.maps.movingai_map import MOVINGAI_SUFFIX

    grid, warning = load_map(file)
    height, width = grid.occupied.shape
    counts = {"occupied": int(grid.occupied.sum()), "unknown": int(grid.unknown.sum())}
    size = f"{width} x {height} of {grid.resolution:g} m"
    kind = "MovingAI map" if file.suffix == MOVINGAI_SUFFIX else "ROS map"
    return {"format": kind, "cells": size, **counts, "warnings": [warning] if warning else []}


def _goals_facts(file: Path) -> dict[str, Any]:
    from handcart.primitives.knowledge.place import load_places

    return {"format": "goals for nav2", "places": list(load_places(file).value.places)}


@few_collections()
def _task_facts(file: Path, settings: dict[str, str], quick: bool) -> dict[str, Any]:
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.robot_report.posture_findings import posture_findings
    from handcart.networks.task.preparing import check as check_task
    from handcart.tools.checks.check_task import task_facts
    from handcart.tools.terminal.share_shown import share_shown

    checked = check_task(file, settings=settings)
    with share_shown(f"{file}: how runs end") as watch:
        facts = task_facts(checked.task, watch)
    if not quick:
        facts |= _domain_facts(checked.task)
    robot = checked.task.robot
    postures = map(str, posture_findings(robot, load_robot(robot)))
    lines = [*checked.place_lines(), *facts.get("lines", ())]
    places = {"places": [place.for_programs() for place in checked.places]} if checked.places else {}
    if checked.computed:
        places["computed_places"] = [place.for_programs() for place in checked.computed]
    facts |= {"lines": lines, "warnings": [*checked.warnings, *postures, *facts["warnings"]]}
    return {**facts, **places, "errors": [*checked.errors, *facts["errors"]]}


def _import_domain_checks(knowledge: object) -> None:
    """Import the checks of the domains first: the functions they need are then compiled on other cores,
    while the map is checked here.
    """
    from handcart.tasks.domain import domains, imported

    for domain in domains():
        named = domain.knowledge.files if domain.knowledge else {}
        if domain.task_facts and isinstance(knowledge, dict) and not named.keys().isdisjoint(knowledge):
            imported(domain.task_facts)


def _domain_facts(task: Task) -> dict[str, Any]:
    """Return the facts from the domains whose files the task names."""
    from handcart.tasks.domain import domains, imported

    facts: dict[str, Any] = {}
    for domain in domains():
        named = domain.knowledge.files if domain.knowledge else ()
        if domain.task_facts and any(task.path("knowledge", key) for key in named):
            begin_stage(f"work of the domain {domain.name}")
            facts |= imported(domain.task_facts)(task)
    return facts


def _table_facts(file: Path) -> dict[str, Any]:
    from handcart.files.models.loading import load_document
    from handcart.files.yaml.yaml_document import read_document
    from handcart.networks.analysis.action_table import (
        ActionTable,
        table_absorption,
        table_errors,
        table_warnings,
    )
    from handcart.networks.chains.absorbing_chain import NeverEnds

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
    warnings = [str(warning) for warning in table_warnings(loaded)]
    facts = {"title": loaded.value.title, "warnings": warnings, "errors": table_errors(loaded)}
    return {**facts, "lines": lines, "figures": figures}
