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
from handcart.backends.plain_values import attributes
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
    """Files that a task names for one domain's part of the world model, by their keys under `knowledge:`."""

    paths: Mapping[str, Path]
    """Paths of the named files."""
    start: Pose2
    """map_T_base at first."""
    document: Document
    """The task's file."""
    findings: Findings
    """Findings of all readers; new ones are added here."""

    def read(self, key: str, reader: Callable[[Path], T]) -> T | None:
        """Return the content of the file that the task names under a key.

        Args:
            key: key under `knowledge:`.
            reader: function that reads the file, and raises `FileError` if it is invalid.

        Returns:
            The content; None if the task names no file, or the file is invalid. Its faults are then added to
                `findings`.
        """
        if key not in self.paths:
            return None
        try:
            return reader(self.paths[key])
        except FileError as error:
            self.findings.take(error)
            return None

    def wrong(self, key: str, message: str) -> None:
        """Add a finding with the text `message`, placed at a key under `knowledge:` in the task's file."""
        self.findings.add(self.document.finding(("knowledge", key), message))


class Companion(Protocol):
    """Interface of a motion that the arm makes while the base drives to a place."""

    def motion(self, remaining: Callable[[], float]) -> Iterator[None]:
        """Move the arm, as a generator that yields once in each control period while the base drives.

        Args:
            remaining: function that returns the base's remaining distance, in [m].

        Raises:
            Discrepancy: the motion is impossible.
        """
        ...


class MovedKnowledge(Protocol):
    """Interface of a world model whose places and map are corrected for objects that have moved.

    An object is a thing on the map, such as furniture, whose new pose was measured.
    """

    places: Mapping[str, Place]

    def redraw_moved(self) -> GridMap:
        """Redraw the map with moved things at their measured poses, and return it.

        The returned map also has the unmapped obstacles that the lidar has sensed.
        """
        ...


@dataclass
class Section:
    """Part of the world model for one domain, which is a kind of work; its fields are its entries.

    Entries in `LEARNED` are learned in a run; the other entries are read from files before the run. Each
    entry has a default, for robots that know nothing of the domain. A subclass is a dataclass.
    """

    FILES: ClassVar[Mapping[str, type[FileModel]]] = {}
    """Models of files by their keys under `knowledge:`; the entry named like a key gets the content of its
    file.
    """
    LEARNED: ClassVar[tuple[str, ...]] = ()
    """Entries that a run finds out: a checkpoint keeps them, by their annotated types."""
    ADDED: ClassVar[tuple[str, ...]] = ()
    """Entries of `LEARNED` that older checkpoints lack; they keep their defaults then."""
    ELEMENT: ClassVar[tuple[str, ...]] = ()
    """Entries of `LEARNED` that are cleared (None) when a `repeat` of the task's file goes on to its next
    element.
    """

    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        """Read this domain's files that a task names; faults are added to `files.findings`."""
        read = {key: files.read(key, partial(load, model=model)) for key, model in cls.FILES.items()}
        return cls(**{key: found for key, found in read.items() if found is not None})

    def names(self) -> Mapping[str, Collection[object] | None]:
        """Return the names of things that this section's files define, by kind, such as the names of all
        objects.

        A primitive's parameter annotated with `Names(KIND)` has to be one of the names of this kind, and
        `{all: KIND}` in a task file is replaced by all of them. The names of a kind are None if the file that
        defines them is invalid.
        """
        return {}

    def fit(self, robot: RobotFile, grid: GridMap, places: Mapping[str, Place]) -> Iterator[Finding]:
        """Compute data that depend on the robot, such as places of its base; yield findings if that fails.

        The method is called once, before anything moves. Afterwards, `places` also returns the computed
        places.

        Args:
            robot: the robot's file.
            grid: the map.
            places: places of the map.
        """
        return iter(())

    def warnings(self) -> Iterable[Finding]:
        """Return findings after `fit` that a user should know before a run, and that do not forbid it."""
        return ()

    def places(self) -> Mapping[str, Place]:
        """Return the places that the domain's files add to those of the map, by name.

        Places that depend on the robot are included only after `fit` has computed them.
        """
        return {}

    def movable_areas(self) -> Iterable[MovableArea]:
        """Return the areas of the map whose contents may have moved since the files were written.

        The localizer ignores lidar points in these areas.
        """
        return ()

    def moved_things(self) -> Iterable[MovedThing]:
        """Return the things whose measured pose differs from their pose on the map; routes avoid them at the
        measured pose.
        """
        return ()

    def measuring(
        self, robot: Robot, model: MovedKnowledge, place: str, report: Callable[..., None]
    ) -> Generator[None, None, bool] | None:
        """Return a generator that measures the thing to which a place belongs; None if that is impossible.

        The generator runs while the base is at rest near the place, and moves the place with the measured
        thing. It returns whether the thing was seen.

        Args:
            robot: the robot.
            model: world model in which the place is moved.
            place: name of the place to which the base is about to drive.
            report: function that receives metrics of the measurement.
        """
        return None

    def discs(self) -> FloatArray:
        """Return known obstacles for a base that plans without a map, as discs (n, 3), in [m].

        A disc is x, y and radius, in the frame in which the robot's pose is given.
        """
        return np.empty((0, 3))

    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield a finding for each requirement of the domain that a robot's file does not meet.

        The requirements are checked before anything moves.
        """
        return iter(())

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """Return the motion that the arm makes while the base drives to a place that this section of the
        world model knows; None for no motion.
        """
        return None

    def contacts_on_the_way(self, place: str) -> Sequence[MeantContact]:
        """Return the contacts that are intended while the arm moves during a drive of the base to a place."""
        return ()

    def noted(self) -> dict[str, Any]:
        """Return the entries of the section that a run learns, by name and ready for JSON.

        The journal records changes of these entries.
        """
        return {name: getattr(self, name) for name in self.LEARNED}

    @classmethod
    def entries(cls) -> tuple[str, ...]:
        """Return the names of the entries (named pieces of knowledge) of this section of the world model."""
        return tuple(field.name for field in fields(cls))

    def forget_element(self) -> None:
        """Set all entries of the section that its class attribute `ELEMENT` names to None.

        These entries belong to one element of a list over which the task repeats actions. The method is
        called when the task goes on to the next element.
        """
        for name in self.ELEMENT:
            setattr(self, name, None)

    @classmethod
    def with_added(cls, learned: object) -> object:
        """Return a checkpoint's values of learned entries, with defaults for `ADDED` ones that it lacks."""
        if not isinstance(learned, dict):
            return learned
        return {**attributes(cls(), {name: types_of(cls)[name] for name in cls.ADDED}), **learned}

    @classmethod
    def learned_types(cls) -> dict[str, Any]:
        """Return the types of the fields for knowledge that the robot gains during a run; a checkpoint keeps
        them.
        """
        return {name: types_of(cls)[name] for name in cls.LEARNED}


def types_of(kind: type) -> Mapping[str, Any]:
    """Return the annotated types of the fields of the class `kind`, by the field's name."""
    return _types_of(kind)


@cache
def _types_of(kind: type) -> Mapping[str, Any]:
    return MappingProxyType(typing.get_type_hints(kind))
