"""`handcart activity`: world, objects and task from an activity of BEHAVIOR-1K."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def make_activity(
    name: Annotated[
        str | None, typer.Argument(help="name of the activity, such as re_shelving_library_books")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="new or empty folder to write into")] = None,
    definition: Annotated[int, typer.Option(min=0, help="number of its definition")] = 0,
    robot: Annotated[str, typer.Option(help="name of the robot, or a file beside that folder")] = "librarian",
    scale: Annotated[bool, typer.Option(help="make narrower what its fingers can't take")] = False,
    listed: Annotated[
        bool, typer.Option("--list", help="list what can be made, and why the others can't")
    ] = False,
) -> None:
    """Write world.yaml, map.yaml, places.yaml, objects.yaml, activity.yaml and task.yaml of an activity,
    which is a household task.
    """
    if listed:
        from handcart.evaluation.activities.listing import list_activities, summary_lines

        for line in summary_lines(list(list_activities(robot, scale))):
            print(line)
        return
    if name is None or out is None:
        missing = "NAME" if name is None else "--out FOLDER"
        raise typer.BadParameter(f"{missing} is missing; allowed: NAME -o FOLDER, or --list")
    _make(name, out, definition, robot, scale)


def _make(name: str, out: Path, definition: int, robot: str, scale: bool) -> None:
    from handcart.evaluation.activities.making import make
    from handcart.tools.terminal.writing import NotWritable, check_folder

    check_folder(out)
    if out.exists() and any(out.iterdir()):
        raise NotWritable(out, "there are files in it", "a new or an empty folder")
    try:
        made = make(name, definition, out, robot, scale)
    except OSError as error:
        raise NotWritable(out, error.strerror, "a new or an empty folder") from None
    for line in made.words():
        print(line)
