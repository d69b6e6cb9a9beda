"""`handcart activity`: world, objects and task from an activity of BEHAVIOR-1K."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def make_activity(
    name: Annotated[str, typer.Argument(help="name of the activity, such as re_shelving_library_books")],
    out: Annotated[Path, typer.Option("--out", "-o", help="new or empty folder to write into")],
    definition: Annotated[int, typer.Option(min=0, help="number of its definition")] = 0,
    robot: Annotated[str, typer.Option(help="name of the robot, or a file beside that folder")] = "librarian",
    scale: Annotated[bool, typer.Option(help="make narrower what its fingers can't take")] = False,
) -> None:
    """Write world.yaml, map.yaml, places.yaml, objects.yaml, activity.yaml and task.yaml of an activity."""
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
