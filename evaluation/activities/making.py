"""An activity's files, from its definition."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError, Finding
from handcart.primitives.objects.files.object_findings import OPENING_MARGIN_MM

from .activity_files import write_activity
from .definition import Definition, load_definition
from .relations import ActivityRelations, relations_of
from .room import Room, furnish
from .thing_relation import entry_of
from .thing_table import CarriedEntry


@dataclass(frozen=True)
class MadeActivity:
    """An activity (household task) whose files were written, with its simulated room, the files' folder, and
    the factors by which the widths of things were reduced so that they fit between the robot's fingers.
    """

    definition: Definition
    room: Room
    folder: Path
    scaled: Mapping[str, float]
    """Factors of the widths that were made narrower, by term."""

    def words(self) -> Iterator[str]:
        """Yield lines of text for people: what was written where, and how to run the activity."""
        count, pieces = len(self.room.at_end), ", ".join(piece.name for piece in self.room.pieces)
        yield f"{self.definition.name}: {count} things to move, in a room with {pieces}; in {self.folder}"
        for term, factor in self.scaled.items():
            yield f"  made narrower for the fingers: {self.room.names[term]}, by {factor:.2f}"
        yield f"  handcart run {self.folder / 'task.yaml'}"


def make(
    name: str, instance: int, folder: Path, robot: str = "librarian", scale: bool = False
) -> MadeActivity:
    """Write the files of an activity.

    Args:
        name: name of the activity.
        instance: number of its definition.
        folder: folder to write into.
        robot: name or file of the robot.
        scale: True to make things narrower that are too wide for the robot's fingers, False to reject them.

    Raises:
        NoBddl: the package with the definitions is missing.
        FileError: the activity is unknown, or has a thing or relation that is unknown or impossible.
        OSError: the folder cannot be written.
    """
    definition, room, scaled = plan_activity(name, instance, robot, scale)
    write_activity(definition, room, folder, _named_from(folder, robot))
    return MadeActivity(definition, room, folder, scaled)


def plan_activity(
    name: str, instance: int, robot: str, scale: bool
) -> tuple[Definition, Room, Mapping[str, float]]:
    """Return an activity's definition, its room, and the width factor of each narrowed thing.

    The factors are by the things' terms in the definition, such as `book.n.02_1`.

    Args:
        name: name of the activity.
        instance: number of its definition.
        robot: name or file of the robot.
        scale: True to make things narrower that are too wide for the robot's fingers, False to reject them.

    Raises:
        NoBddl: the package with the definitions is missing.
        FileError: the activity is unknown, or has a thing or relation that is unknown or impossible.
    """
    definition = load_definition(name, instance)
    relations = relations_of(definition)
    sizes, scaled = _sizes(definition, relations, _widest_mm(robot), scale)
    return definition, furnish(definition, relations, sizes), scaled


def _named_from(folder: Path, robot: str) -> str:
    """Return how a task in a folder names a robot: its name, or the path of its file from there."""
    if not robot.endswith((".yaml", ".yml")) or (SHIPPED_FOLDER / robot).exists():
        return robot
    file, beside = Path(robot).resolve(), folder.resolve().parent
    if not file.is_relative_to(beside):
        words = f"the task can't name a file that is not below {beside}"
        raise FileError([Finding(robot, 0, 0, f"{words}; allowed: a robot's name, or a file below that")])
    return Path(os.path.relpath(file, folder.resolve())).as_posix()


@cache
def _widest_mm(robot: str) -> float:
    """Return the width of the widest thing that the robot's fingers take."""
    gripper = load_robot(robot).gripper
    if gripper is None:
        raise FileError([Finding(robot, 0, 0, "the robot has no gripper; allowed: a robot with fingers")])
    return gripper.opening_mm - OPENING_MARGIN_MM


def _sizes(
    definition: Definition, relations: ActivityRelations, widest: float, scale: bool
) -> tuple[dict[str, CarriedEntry], dict[str, float]]:
    """Return the sizes of all carried things, and the factors of those made narrower."""
    sizes: dict[str, CarriedEntry] = {}
    scaled: dict[str, float] = {}
    findings = []
    moved = {move.thing for move in relations.moves}
    for item in relations.initial:
        entry = entry_of(definition, item.thing)
        assert isinstance(entry, CarriedEntry)  # by its relation
        narrowest = min(entry.size_mm[:2])
        sizes[item.thing] = entry
        if item.thing not in moved and min(entry.size_mm) > widest:
            words = f"{item.thing} has no side narrow enough for the fingers: {min(entry.size_mm):g} mm"
            findings.append(definition.finding([item.thing], f"{words}; allowed: at most {widest:g} mm"))
        if item.thing not in moved or narrowest <= widest:
            continue
        if scale:
            scaled[item.thing] = factor = widest / narrowest
            x, y, z = entry.size_mm
            narrow = (round(x * factor, 1), round(y * factor, 1), z)
            sizes[item.thing] = entry.model_copy(update={"size_mm": narrow})
        else:
            words = f"{item.thing} is too wide for the fingers: {narrowest:g} mm"
            findings.append(
                definition.finding([item.thing], f"{words}; allowed: at most {widest:g} mm, or --scale")
            )
    if findings:
        raise FileError(findings)
    return sizes, scaled
