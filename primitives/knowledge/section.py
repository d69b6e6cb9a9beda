"""What a robot knows of one domain."""

from __future__ import annotations

import typing
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.yaml.yaml_document import Document
from handcart.primitives.contract.meant_contact import MeantContact
from handcart.robotics.geometry.pose2 import Pose2

from .place import Place

T = TypeVar("T")


@dataclass(frozen=True)
class NamedFiles:
    """The files that a task names for a section, by their keys under `knowledge:`."""

    paths: Mapping[str, Path]
    """Of those that are there."""
    start: Pose2
    """map_T_base at first."""
    document: Document
    """The task's file."""
    findings: Findings
    """What is wrong is added here."""

    def read(self, key: str, reader: Callable[[Path], T]) -> T | None:
        """What is in a file; None where the task names none, or it is wrong: then that is added."""
        if key not in self.paths:
            return None
        try:
            return reader(self.paths[key])
        except FileError as error:
            self.findings.take(error)
            return None

    def wrong(self, key: str, message: str) -> None:
        """Add that something is wrong with a key."""
        self.findings.add(self.document.finding(("knowledge", key), message))


class Companion(Protocol):
    """What the arm does while the base drives to a place."""

    def motion(self, remaining: Callable[[], float]) -> Iterator[None]:
        """One period of it for each of the base's.

        Args:
            remaining: tells how far the base still has to go, in [m].

        Raises:
            Discrepancy: it can't be done.
        """
        ...


@dataclass
class Section:
    """A domain's part of the world model: a dataclass whose fields are its entries.

    Entries in `LEARNED` are found out in a run; the others are read from files before it. Each has a default,
    for robots that know nothing of the domain.
    """

    FILES: ClassVar[Mapping[str, type[FileModel]]] = {}
    """Models of files by their keys under `knowledge:`; the entry of that name gets what is in the file."""
    LEARNED: ClassVar[tuple[str, ...]] = ()
    """Entries that a run finds out: a checkpoint keeps them, by their annotated types."""
    ELEMENT: ClassVar[tuple[str, ...]] = ()
    """Of these, those that are forgotten (None) when an element of a repeat is left."""

    @classmethod
    def load(cls, files: NamedFiles) -> Self:
        """Read the files that a task names; what is wrong is added to `files.findings`."""
        read = {key: files.read(key, partial(load, model=model)) for key, model in cls.FILES.items()}
        return cls(**{key: found for key, found in read.items() if found is not None})

    def names(self) -> Mapping[str, Collection[object]]:
        """What can be named: parameters marked with `Names(KIND)` are held against it, and `{all: KIND}` in a
        task file goes over it."""
        return {}

    def places(self) -> Mapping[str, Place]:
        """Places of the map that these files add."""
        return {}

    def discs(self) -> NDArray[np.float64]:
        """(n, 3) x, y, radius in [m] of what is known to stand where a base plans without a map."""
        return np.empty((0, 3))

    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """What a robot can't do there, known before anything moves."""
        return iter(())

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """What the arm does while the base drives to a place of this domain; None where nothing is known."""
        return None

    def contacts_on_the_way(self, place: str) -> Sequence[MeantContact]:
        """What the companion means to touch."""
        return ()

    def noted(self) -> dict[str, Any]:
        """What is known now, ready for JSON: the journal has what has changed. As it is, what was learned."""
        return {name: getattr(self, name) for name in self.LEARNED}

    @classmethod
    def entries(cls) -> tuple[str, ...]:
        """Names of its entries."""
        return tuple(each.name for each in fields(cls))

    def forget_element(self) -> None:
        """Forget what belongs to an element of a repeat."""
        for name in self.ELEMENT:
            setattr(self, name, None)

    @classmethod
    def learned_types(cls) -> dict[str, Any]:
        """Types of the entries that a checkpoint keeps."""
        return {name: types_of(cls)[name] for name in cls.LEARNED}


def types_of(kind: type) -> Mapping[str, Any]:
    """Annotated types of a class, by name."""
    return _types_of(kind)


@cache
def _types_of(kind: type) -> Mapping[str, Any]:
    return MappingProxyType(typing.get_type_hints(kind))
