"""World model: the robot's given, seen and learned knowledge."""

from __future__ import annotations

import typing
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, fields
from dataclasses import field as dataclass_field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, TypeVar, cast

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.plain_values import attributes, set_attributes
from handcart.backends.robot.robot import Robot
from handcart.backends.saved_state import NotAState
from handcart.files.errors import Finding, HandcartError
from handcart.files.stages import begin_stage
from handcart.files.suggest import suggest
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.movable_areas import with_movable
from handcart.robotics.navigation.maps.moved_things import beside, with_moved
from handcart.robotics.navigation.maps.scan_layer import ScanLayer
from handcart.robotics.navigation.maps.speed_limits import SpeedLimits
from handcart.robotics.numerics.arrays import FloatArray

from .meant_contact import MeantContact
from .place import Place
from .section import Companion, Section, types_of
from .sections import name_of, sections

MOVED_MARGIN_M = 0.08  # from the outline of a thing that was measured, within which a reading is of it


class Declares(Protocol):
    """Interface of a class that declares which entries of the world model it reads and writes.

    Every primitive implements it.
    """

    reads: ClassVar[tuple[str, ...]]
    writes: ClassVar[tuple[str, ...]]

    @classmethod
    def label(cls) -> str:
        """Return the name of the primitive in task files."""
        ...


class UnknownFact(HandcartError, LookupError):
    """Error: a parameter names an entry that the model does not have, or whose value is not known yet."""


class UndeclaredAccess(HandcartError, AttributeError):
    """Error: a primitive reads or writes an entry of the world model that it didn't declare."""


class Detour(NamedTuple):
    """Route to a place that was planned around sensed obstacles."""

    goal: str
    points: FloatArray
    """(n, 2) on the map, in [m]."""


SectionT = TypeVar("SectionT", bound=Section)


@dataclass
class WorldModel:
    """Knowledge of the robot: map, places, obstacles, and a section for each domain (kind of work).

    A task may repeat its actions for each element of a list, such as each object to fetch; when the task goes
    on to the next element, `clear_element` clears the knowledge about the one before.
    """

    map: GridMap
    places: Mapping[str, Place]
    obstacles: FloatArray = dataclass_field(default_factory=lambda: np.empty((0, 2)))
    """(n, 2) sensed points that are not on the map, x and y on the map in [m]; kept for the run."""
    sensed_cells: FloatArray = dataclass_field(default_factory=lambda: np.empty((0, 4)))
    """(n, 4) cells sensed lately as occupied that the map does not show, each with x, y on the map in [m],
    score, and time of the last hit in [s]; beams that pass through a cell clear it (`ScanLayer`).
    """
    bumps: FloatArray = dataclass_field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) places where the base ran into an obstacle that no sensor shows, each with x, y of the base on
    the map in [m] and direction of its motion on the map in [rad]; kept for the run.
    """
    arm_bumps: FloatArray = dataclass_field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) points of the arm when the base ran into an obstacle, one of which may have touched, each with
    x, y on the map in [m] and direction of the motion in [rad]; kept for the run.
    """
    detour: Detour | None = None
    """Planned detour; kept for one element of a repeat."""
    in_hand: str = ""
    """Name of the thing in the hand, by the primitive that took it; empty if none or unknown."""
    speed_limits: SpeedLimits | None = None
    """Speed limits by place on the map."""
    sections: dict[str, Section] = dataclass_field(default_factory=dict)
    """Sections by the names of their domains; missing ones are created empty on first use."""

    LEARNED: ClassVar = {
        "places": dict[str, Place],
        "obstacles": FloatArray,
        "sensed_cells": FloatArray,
        "bumps": FloatArray,
        "arm_bumps": FloatArray,
        "detour": Detour | None,
        "in_hand": str,
    }
    """Entries that a checkpoint keeps in addition to those of the sections, with their types."""
    ENTRIES: ClassVar = (
        "map",
        "places",
        "obstacles",
        "sensed_cells",
        "bumps",
        "arm_bumps",
        "detour",
        "speed_limits",
        "discs",
    )

    def __post_init__(self) -> None:
        self._given_map = self.map
        self._noted = self._now()

    @property
    def discs(self) -> FloatArray:
        """Known obstacles for a base that plans without a map, as discs (n, 3), in [m].

        A disc is x, y and radius, in the frame in which the robot's pose is given.
        """
        return np.vstack([np.empty((0, 3)), *(section.discs() for section in self.sections.values())])

    def of(self, kind: type[SectionT]) -> SectionT:
        """Return the section of a given class, which holds the knowledge for one kind of work."""
        name = name_of(kind)
        section = self._section(name, kind)
        assert isinstance(section, kind)
        return section

    def _section(self, name: str, kind: type[Section]) -> Section:
        if name not in self.sections:
            self.sections[name] = kind()
            self._noted |= self.sections[name].noted()
        return self.sections[name]

    def fit(self, robot: RobotFile) -> list[Finding]:
        """Complete the model for a robot, before the start of a run.

        The sections compute data that depend on the robot; the places among them are added to `places`. Areas
        whose content may have moved are marked on the map.

        Returns:
            Findings on data that cannot be computed for this robot.
        """
        begin_stage("places of the base")
        found: list[Finding] = []
        for section in self.sections.values():
            found += section.fit(robot, self.map, self.places)
            self.places = {**self.places, **section.places()}
        areas = [area for section in self.sections.values() for area in section.movable_areas()]
        if areas and robot.range_sensor is not None:
            height = float(base_T_frame(robot.urdf_text(), robot.lidar_link)[2, 3])
            self.map = with_movable(self.map, areas, height)
        self._given_map = self.map
        self._noted = self._now()
        return found

    def redraw_moved(self) -> GridMap:
        """Redraw the map, with things that have moved at their measured poses.

        Sensed cells (obstacles in lidar scans that the map lacked) near a moved thing are dropped, because
        they showed this thing.

        Returns:
            The new map, with the remaining sensed cells drawn in.
        """
        things = [thing for section in self.sections.values() for thing in section.moved_things()]
        self.map = with_moved(self._given_map, things)
        for thing in things:
            own = beside(self.sensed_cells[:, :2], thing.now, MOVED_MARGIN_M)
            self.sensed_cells = self.sensed_cells[~own]
        layer = ScanLayer(self.map)
        layer.restore(self.sensed_cells)
        return layer.merged()

    def is_redrawn(self) -> bool:
        """Return whether the map was redrawn with moved things, so that it differs from the map file."""
        return self.map is not self._given_map

    def measuring(
        self, robot: Robot, place: str, report: Callable[..., None]
    ) -> Generator[None, None, bool] | None:
        """Return a generator that measures the object before a place, such as a door; None if there is none.

        Args:
            robot: the robot.
            place: name of the place to which the base is about to drive.
            report: function that receives metrics of the measurement.
        """
        found = (section.measuring(robot, self, place, report) for section in self.sections.values())
        return next((steps for steps in found if steps is not None), None)

    def clear_element(self) -> None:
        """Clear what was learned about the present element of the list over which a task repeats actions."""
        self.detour = None
        for section in self.sections.values():
            section.forget_element()

    def view(self, primitive: Declares) -> ModelView:
        """Return a view of the model that gives access only to the entries that a primitive declares."""
        return ModelView(self, primitive)

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """Return the motion that the arm makes while the base drives to a place; None for no motion."""
        found = (section.companion(robot, place) for section in self.sections.values())
        return next((companion_ for companion_ in found if companion_ is not None), None)

    def contacts_on_the_way(self, place: str) -> Sequence[MeantContact]:
        """Return the intended contacts of the arm's motions while the base drives to a place."""
        return [
            contact for section in self.sections.values() for contact in section.contacts_on_the_way(place)
        ]

    def lookup(self, path: str) -> Any:
        """Return the value at a path in the model, such as `cup.size`, to which a parameter refers.

        Raises:
            UnknownFact: the value is not known yet.
        """
        first, *names = path.split(".")
        value = getattr(self._owner(first), first, None)
        for name in names:
            value = getattr(value, name, None)
        if value is None:
            raise UnknownFact(f"{path} is not known yet")
        return value

    def _owner(self, entry: str) -> object:
        if entry in self.ENTRIES:
            return self
        found = ((name, kind) for name, kind in sections().items() if entry in kind.entries())
        return next((self._section(name, kind) for name, kind in found), None)

    @classmethod
    def entry_types(cls) -> dict[str, Any]:
        """Return the type of each entry (named piece of knowledge), including those of all domains."""
        found = {name: kind for name, kind in types_of(cls).items() if name in cls.ENTRIES}
        for section in sections().values():
            found |= {name: types_of(section)[name] for name in section.entries()}
        return found

    @classmethod
    def unknown_at_first(cls) -> set[str]:
        """Return the entries that are None until a file or a primitive sets them."""
        kinds: list[type[WorldModel] | type[Section]] = [cls, *sections().values()]
        return {field.name for kind in kinds for field in fields(kind) if field.default is None}

    @classmethod
    def type_of(cls, path: str) -> Any:
        """Return the type of the value at a path in the world model, such as `cup.size`; of a type "T or
        None", return T.

        Raises:
            UnknownFact: the path names no entry of the world model.
        """
        known = cls.entry_types()
        kind: Any = None
        for name in path.split("."):
            if name not in known:
                raise UnknownFact(f"the world model has no {path!r}{suggest(name, known)}")
            kind = known[name]
            options = [arg for arg in typing.get_args(kind) if arg is not type(None)]
            kind = options[0] if type(None) in typing.get_args(kind) else kind
            known = {key: hint for key, hint in _hints(kind).items() if key.islower()}
        return kind

    def state(self) -> dict[str, Any]:
        """Return the knowledge learned in the run, as plain data for a checkpoint."""
        own = {name: attributes(section, section.learned_types()) for name, section in self.sections.items()}
        return {**attributes(self, self.LEARNED), "sections": own}

    def set_state(self, state: object) -> None:
        """Restore the knowledge returned by `state`.

        Raises:
            NotAState: the data is not the state of a world model.
        """
        if not isinstance(state, dict) or not isinstance(state.get("sections"), dict):
            raise NotAState("no state of a world model; needed: sections")
        none = np.empty((0, 3))
        cells = np.empty((0, 4))
        state = {"bumps": none, "arm_bumps": none, "sensed_cells": cells, **state}  # older states have none
        there = sections()
        if unknown := state["sections"].keys() - there.keys():
            names = ", ".join(map(str, sorted(unknown, key=str)))
            raise NotAState(f"no state of a world model: nothing is known of {names} here")
        learned = {key: item for key, item in state.items() if key != "sections"}
        set_attributes(self, self.LEARNED, {"in_hand": "", **learned})  # older checkpoints have none
        for name, learned in state["sections"].items():
            section = self._section(name, there[name])
            set_attributes(section, section.learned_types(), section.with_added(learned))
        self.redraw_moved()
        self._noted = self._now()

    def taken_changes(self) -> dict[str, Any]:
        """Return the entries of the model learned or cleared since the last call, ready for JSON."""
        now = self._now()
        if now == self._noted:
            return {}
        changes = {name: value for name, value in now.items() if value != self._noted.get(name)}
        self._noted = now
        return changes

    def _now(self) -> dict[str, Any]:
        now: dict[str, Any] = {
            "obstacles": len(self.obstacles),
            "bumps": self.bumps.round(4).tolist() if self.bumps.size else [],
            "detour": self.detour.points.round(4).tolist() if self.detour else None,
            "in_hand": self.in_hand,
        }
        for section in self.sections.values():
            now |= section.noted()
        return now


def _hints(kind: Any) -> Mapping[str, Any]:
    return types_of(kind) if isinstance(kind, type) else {}


class ModelView:
    """View of the world model for one primitive, which can only access the entries that it declares."""

    if TYPE_CHECKING:
        map: GridMap
        places: Mapping[str, Place]
        obstacles: FloatArray
        sensed_cells: FloatArray
        bumps: FloatArray
        arm_bumps: FloatArray
        detour: Detour | None
        speed_limits: SpeedLimits | None
        discs: FloatArray

    def __init__(self, model: WorldModel, primitive: Declares, part: object = None) -> None:
        """Restrict a model, or the section `part` of it, to what a primitive declares."""
        own = self.__dict__  # setting an attribute would ask the primitive
        own["_model"], own["_primitive"] = model, primitive
        own["_part"] = model if part is None else part

    def of(self, kind: type[SectionT]) -> SectionT:
        """Return a view of the section of class `kind`, with only the entries that the primitive declares."""
        model = self.__dict__["_model"]
        return cast(SectionT, ModelView(model, self.__dict__["_primitive"], model.of(kind)))

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """Return the arm's motion while the base drives to a place; None if the arm does not move then."""
        found: Companion | None = self.__dict__["_model"].companion(robot, place)
        return found

    def redraw_moved(self) -> GridMap:
        """Return the map redrawn with moved things at their measured poses, and with sensed obstacles."""
        grid: GridMap = self.__dict__["_model"].redraw_moved()
        return grid

    def is_redrawn(self) -> bool:
        """Return whether the map was redrawn with moved things, so that it differs from the map file."""
        return bool(self.__dict__["_model"].is_redrawn())

    def measuring(
        self, robot: Robot, place: str, report: Callable[..., None]
    ) -> Generator[None, None, bool] | None:
        """Return a generator that measures the object before a place, such as a door; None if there is none.

        Args:
            robot: the robot.
            place: name of the place to which the base is about to drive.
            report: function that receives metrics of the measurement.
        """
        found: Generator[None, None, bool] | None
        found = self.__dict__["_model"].measuring(robot, place, report)
        return found

    def __getattr__(self, name: str) -> Any:
        primitive, part = self.__dict__["_primitive"], self.__dict__["_part"]
        if name not in primitive.reads + primitive.writes:
            if isinstance(part, Section) and name not in part.entries() and not name.startswith("_"):
                return getattr(part, name)  # a method or property computed from entries
            raise UndeclaredAccess(f"{primitive.label()} reads {name!r} without declaring it in `reads`")
        return getattr(part, name)

    def __setattr__(self, name: str, value: Any) -> None:
        primitive = self.__dict__["_primitive"]
        if name not in primitive.writes:
            raise UndeclaredAccess(f"{primitive.label()} writes {name!r} without declaring it in `writes`")
        setattr(self.__dict__["_part"], name, value)
