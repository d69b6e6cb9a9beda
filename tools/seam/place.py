"""`handcart place`: a task from a robot and a path of its tool, and a picture of the base poses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.files.yaml.yaml_document import Document


def place(
    robot: Annotated[str, typer.Argument(help="a shipped robot's name, or a robot's YAML file")],
    path: Annotated[Path, typer.Argument(help="a seam: CSV with a pose of the tool a line")],
    output: Annotated[Path, typer.Option("-o", "--output", help="folder to write into")] = Path("seam"),
    placements: Annotated[
        int | None, typer.Option(help="maximum number (default: as few as needed)", min=1)
    ] = None,
    work_piece: Annotated[
        Path | None,
        typer.Option(help="a file with the work piece (default: nothing is in the arm's way)"),
    ] = None,
) -> None:
    """Divide the path of a tool among places of the base, from which the arm reaches its parts; write a task
    and its files.

    The folder gets task.yaml with the files that it names, and the picture placements.svg.
    """
    from handcart.backends.description.robot_file import UnknownPosture
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.evaluation.seam.seam_placing import NoToolArm, place_seam, write_task
    from handcart.files.errors import FileError
    from handcart.files.models.loading import load
    from handcart.primitives.seam.work_piece import WorkPiece
    from handcart.tools.terminal.first_use import announced
    from handcart.tools.terminal.writing import NotWritable, check_folder

    check_folder(output)
    spec = load_robot(robot)
    piece = load(work_piece, WorkPiece) if work_piece else None
    try:
        with announced(f"placing the base along {path}"):
            placed = place_seam(spec, path, piece, placements)
    except NoToolArm as error:
        raise FileError([_document(robot).finding(error.key, str(error))]) from None
    except UnknownPosture as error:
        raise FileError([_document(robot).finding(("arm", "postures"), str(error))]) from None
    try:
        write_task(placed, path, _named(robot, output), output)
    except OSError as error:
        raise NotWritable(output, error.strerror) from None
    count = len(placed.placements.bases)
    print(f"{placed.seam.length:.2f} m of seam, {count} placements, score {placed.share:.3f}")
    for line in placed.words():
        print(f"  {line}")
    own = f" --robot {robot}" if robot.endswith((".yaml", ".yml")) else ""
    print(f"run it: handcart run {output / 'task.yaml'}{own}")


def _document(robot: str) -> Document:
    """Return the robot's file as a document, to look up line numbers."""
    from handcart.backends.description.robot_names import robot_path
    from handcart.files.yaml.yaml_document import read_document

    return read_document(robot_path(robot))


def _named(robot: str, folder: Path) -> str:
    """Return the robot's name as a task in that folder has to write it."""
    import os

    if not robot.endswith((".yaml", ".yml")):
        return robot
    return Path(os.path.relpath(robot, folder)).as_posix()
