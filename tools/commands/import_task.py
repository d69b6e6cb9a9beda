"""`handcart import`: a behaviour tree, a state machine or a model of another program as a task."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

MAX_LOST_COMMENTS = 200
"""Lost constructs that are written into the task's file."""


def import_task(
    file: Annotated[Path, typer.Argument(help="*.xml, *.scxml, *.jani, *.pddl, *.yaml (SMACH)")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the task's file")],
    problem: Annotated[Path | None, typer.Option("--problem", help="the problem of a PDDL domain")] = None,
    robot: Annotated[str, typer.Option("--robot", help="the robot of the task")] = "librarian",
) -> None:
    """Convert a behaviour tree, a state machine or a planning model into a task's file.

    Parts that a task cannot express are reported.
    """
    from handcart.evaluation.interchange.importing import import_file, primitives_in
    from handcart.evaluation.interchange.task_draft import GUESSED_COST_S, yaml_text
    from handcart.files.printable import counted, printable
    from handcart.primitives.registry import primitive_names
    from handcart.tools.terminal.writing import write_text

    imported = import_file(file, problem)
    data = imported.data
    if "robot" not in data:
        head = {"format": data["format"], "title": data["title"], "robot": robot}
        data = {**head, **{key: value for key, value in data.items() if key not in head}}
    lost = [str(item.finding(str(file))) for item in imported.lost]
    unknown = sorted(set(primitives_in(imported)) - set(primitive_names()))
    comments = [f"Read from {file.name}."]
    if "robot" not in imported.data:
        comments.append(f"cost_s: {GUESSED_COST_S:g} is a guess.")
    write_text(output, yaml_text(data, [*comments, *map(printable, lost[:MAX_LOST_COMMENTS])]))
    for line in lost:
        print(line, file=sys.stderr)
    if unknown:
        print(printable(f"primitives to be written: {', '.join(unknown)}"), file=sys.stderr)
    counts = f"{counted(len(data['actions']), 'action')}, {counted(len(lost), 'construct')} not expressed"
    print(printable(f"written: {output}, {counts}"))
