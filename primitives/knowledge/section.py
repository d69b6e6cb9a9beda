"""Knowledge about one domain."""

from __future__ import annotations

import typing
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.yaml.yaml_document import Document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.movable_areas import MovableArea
from handcart.robotics.navigation.maps.moved_things import MovedThing
from handcart.robotics.numerics.arrays import FloatArray

from .meant_contact import MeantContact
from .place import Place

T = TypeVar("T")


@dataclass(frozen=True)
class NamedFiles:
    """The files that a task names for a section, by their keys under `knowledge:`."""

    paths: Mapping[str, Path]
    """Paths of the named files."""
    start: Pose2
    """map_T_base at first."""
    document: Document
    """The task's file."""
    findings: Findings
    """Findings of all readers; new ones are added here."""

    def read(self, key: str, reader: Callable[[Path], T]) -> T | None:
        """Return the content of a file; None if the task names none, or if it is invalid, which adds
        findings.
        """
        if key not in self.paths:
            return None
        try:
            return reader(self.paths[key])
        except FileError as error:
            self.findings.take(error)
            return None

    def wrong(self, key: str, message: str) -> None:
        """Add a finding, placed at a key under `knowledge:` in the task's file."""
        self.findings.add(self.document.finding(("knowledge", key), message))


class Companion(Protocol):
    """Motion of the arm while the base drives to a place."""

    def motion(self, remaining: Callable[[], float]) -> Iterator[None]:
        """Yield once for each period of the base's motion.

        Args:
            remaining: returns the base's remaining distance, in [m].

        Raises:
            Discrepancy: the motion is impossible.
        """
        ...


class MovedKnowledge(Protocol):
    """Places and map of a world model, which follow what was measured elsewhere."""

    places: Mapping[str, Place]

    def redraw_moved(self) -> GridMap:
        """Replace the map by one with measured things where they are now; return it with the sensed cells."""
        ...


@dataclass
class Section:
    """A domain's part of the world model: a dataclass whose fields are its entries.

    Entries in `LEARNED` are found out in a run; the others are read from files before it. Each has a default,
    for robots that know nothing of the domain.
    """

    FILES: ClassVar[Mapping[str, type[FileModel]]] = {}
    """Models of files by their keys under `knowledge:`; the entry named like a key gets the content of its
    file.
    """
    LEARNED: ClassVar[tuple[str, ...]] = ()
    """Entries that a run finds out: a checkpoint keeps them, by their annotated types."""
    ELEMENT: ClassVar[tuple[str, ...]] = ()
    """Entries of `LEARNED` that are cleared (None) when a `repeat` of the task's file goes on to its next
    element.
    """

    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        """Read the files that a task names; faults are added to `files.findings`."""
        read = {key: files.read(key, partial(load, model=model)) for key, model in cls.FILES.items()}
        return cls(**{key: found for key, found in read.items() if found is not None})

    def names(self) -> Mapping[str, Collection[object] | None]:
        """Return the known names by kind: parameters marked with `Names(KIND)` are checked against them, and
        `{all: KIND}` in a task file lists them. None: the file with the names of this kind is invalid.
        """
        return {}

    def fit(self, robot: RobotFile, grid: GridMap, places: Mapping[str, Place]) -> Iterator[Finding]:
        """Compute what depends on the robot, such as places of its base; yield what is impossible.

        Called once, before anything moves; `places` then returns the computed ones too.

        Args:
            robot: the robot's file.
            grid: the map.
            places: places of the map.
        """
        return iter(())

    def places(self) -> Mapping[str, Place]:
        """Places of the map that these files add.

        Those that are computed for a robot are missing until `fit`; `names` has their names as "places".
        """
        return {}

    def movable_areas(self) -> Iterable[MovableArea]:
        """Return the areas of the map whose contents may have moved since the files were written.

        The localizer does not use what a lidar sees there.
        """
        return ()

    def moved_things(self) -> Iterable[MovedThing]:
        """Return the things that were measured elsewhere than on the map; routes avoid their new places."""
        return ()

    def measuring(
        self, robot: Robot, model: MovedKnowledge, place: str, report: Callable[..., None]
    ) -> Generator[None, None, bool] | None:
        """Return a measurement of the thing that a place was computed for; None if there is none to measure.

        It runs while the base is at rest near the place, and moves the place with the measured thing. It
        returns whether the thing was seen.

        Args:
            robot: the robot.
            model: knowledge in which the place is moved.
            place: name of the place that the base is about to drive to.
            report: receives metrics.
        """
        return None

    def discs(self) -> FloatArray:
        """Return known obstacles for a base that plans without a map, as discs (n, 3): x, y and radius, in
        [m].

        They are in the parent frame of the robot's pose, such as the map.
        """
        return np.empty((0, 3))

    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield the domain's requirements that a robot does not meet, known before anything moves."""
        return iter(())

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """Return the arm's motion while the base drives to a place of this domain, or None for no motion."""
        return None

    def contacts_on_the_way(self, place: str) -> Sequence[MeantContact]:
        """Return the intended contacts of the companion."""
        return ()

    def noted(self) -> dict[str, Any]:
        """Return the learned knowledge, ready for JSON; the journal records its changes."""
        return {name: getattr(self, name) for name in self.LEARNED}

    @classmethod
    def entries(cls) -> tuple[str, ...]:
        """Return the names of the section's entries."""
        return tuple(field.name for field in fields(cls))

    def forget_element(self) -> None:
        """Clear the entries `ELEMENT` when a `repeat` of the task's file goes on to its next element."""
        for name in self.ELEMENT:
            setattr(self, name, None)

    @classmethod
    def learned_types(cls) -> dict[str, Any]:
        """Return the types of the entries that a checkpoint keeps."""
        return {name: types_of(cls)[name] for name in cls.LEARNED}


def types_of(kind: type) -> Mapping[str, Any]:
    """Return the annotated types of a class, by name."""
    return _types_of(kind)


@cache
def _types_of(kind: type) -> Mapping[str, Any]:
    return MappingProxyType(typing.get_type_hints(kind))
