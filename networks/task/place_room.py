"""Checks of each place of a task before anything moves: is it free, does the robot fit, can it be reached."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import Finding
from handcart.files.models.loading import Loaded
from handcart.files.stages import begin_stage
from handcart.networks.graph.network import Action
from handcart.primitives.knowledge.place import Place, Places
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.ways import Way, Ways

from .primitive_parameters import named_entry
from .task_file import Task

PLACES_KEY = "places"


@dataclass(frozen=True)
class PlaceRoom:
    """A place of the map with its clearance and its route from the robot's start."""

    name: str
    way: Way
    """Route from the robot's start."""
    line: int
    """Line of the place in its file."""
    used: bool
    """True if an action names it, or may name it."""
    driven_to: bool
    """True if an action that drives names it."""

    def words(self) -> str:
        """Return a line of text on the place's clearance, and whether and how it is reached."""
        way = self.way
        room = f"{way.clearance:.2f} m to {way.kind}, needed: {way.needed:.2f} m"
        part = "in no component" if way.component is None else f"component {way.component}"
        reached = f"reached in {way.route.length:.1f} m" if way.route else f"not reached: {way.reason}"
        return f"place {self.name}: {room}; {part}; {reached}{'' if self.used else '; no action uses it'}"

    def for_programs(self) -> dict[str, Any]:
        """Return the place's clearance, the route to it and whether the task uses it, as fields for JSON;
        lengths are in [m].
        """
        way = self.way
        return {
            "name": self.name,
            "line": self.line,
            "clearance_m": _rounded(way.clearance),
            "needed_m": _rounded(way.needed),
            "nearest": way.kind,
            "nearest_m": _rounded_point(way.nearest),
            "fits": way.fits,
            "component": way.component,
            "reachable": way.route is not None,
            "why_not": way.why or None,
            "reason": way.reason or None,
            "narrow_m": None if way.narrow is None else _rounded_point(way.narrow),
            "width_m": _rounded(way.width),
            "width_needed_m": _rounded(way.width_needed),
            "route_m": None if way.route is None else _rounded(way.route.length),
            "used": self.used,
        }


class ComputedPlace(NamedTuple):
    """A place that is in no file, but was computed for the robot, such as a place from which it can grip."""

    name: str
    pose: Pose2
    """map_T_base."""

    def words(self) -> str:
        """Return a line of text with name, position in [m] and heading in [deg] of the place."""
        x, y, heading = self._rounded()
        return f"place {self.name}, computed: x {x:.2f} m, y {y:.2f} m, heading {heading:.0f} deg"

    def for_programs(self) -> dict[str, Any]:
        """Return name, position in [m] and heading in [deg] of the place as fields for JSON."""
        return dict(zip(("name", "x_m", "y_m", "heading_deg"), (self.name, *self._rounded()), strict=True))

    def _rounded(self) -> tuple[float, float, float]:
        """Return x and y in [m] and the heading in [deg]; 0 has no sign."""
        heading = round(math.degrees(self.pose.theta), 1)
        return round(self.pose.x, 3) + 0.0, round(self.pose.y, 3) + 0.0, heading + 0.0


@dataclass(frozen=True)
class PlaceRooms:
    """Clearance and routes of all places of a task, with errors and warnings about them."""

    places: tuple[PlaceRoom, ...] = ()
    errors: tuple[Finding, ...] = ()
    """Places that an action drives to and that cannot be reached."""
    warnings: tuple[Finding, ...] = ()


class _Named(NamedTuple):
    """Names of the places that actions name."""

    names: set[str]
    any: bool
    """True if it may be any place, because the place is chosen only when its action starts."""


def place_findings(places: Loaded[Places], grid: GridMap, chart: Path) -> Iterator[Finding]:
    """Yield a finding for each place whose point is outside a map, in an obstacle or in unknown space.

    Args:
        places: the places, with their file.
        grid: the map.
        chart: path of the map's file, for messages.
    """
    for name, place in places.value.places.items():
        where = _where(place, grid)
        if where:
            wrong = f"place {name!r} is {where} {chart.name}; allowed: the free space of the map"
            yield places.finding(("places", name), wrong, at_key=True)


def _where(place: Place, grid: GridMap) -> str:
    """Return where on the map an unfree place lies, in words; empty if it is free."""
    point = np.array([[place.x_m, place.y_m]])
    if not grid.inside(point)[0]:
        return "outside"
    row, column = grid.to_cell(point)[0]
    if grid.occupied[row, column]:
        return "in an obstacle of"
    return "in unknown space of" if grid.unknown[row, column] else ""


def place_rooms(task: Task, robot: RobotFile, model: WorldModel, start: Pose2) -> PlaceRooms:
    """Return clearance (distance to obstacles) and routes of all places of a task.

    The result is empty if the task has no map or no places, or if the robot's base is car-like, for which no
    routes are planned on a map.

    Args:
        task: the task.
        robot: the robot's file.
        model: the robot's world model.
        start: pose of the base at the start, on the map; if the task does not know it, routes begin at the
            first place.
    """
    loaded = task.knowledge.places
    if loaded is None or task.path("knowledge", "map") is None or robot.drive.kind == "ackermann":
        return PlaceRooms()
    named, driven = _named(task.network.actions), _named(task.network.actions, driving=True)
    if not task.knowledge.is_start_known:  # it is found later: ways are those between the places
        start = next((place.pose for place in loaded.value.places.values()), start)
    begin_stage("ways to the places")
    ways = Ways(model.map, robot.footprint_shape, start)
    rooms = tuple(
        PlaceRoom(
            name,
            ways.to(place.pose, place.front if place.docks else None),
            loaded.document.key_position((PLACES_KEY, name))[0],
            named.any or name in named.names or name == _start_of(task),
            name in driven.names,
        )
        for name, place in loaded.value.places.items()
    )
    errors = [_cant(loaded, room, task) for room in rooms if room.driven_to and room.way.route is None]
    return PlaceRooms(rooms, tuple(errors), tuple(_warnings(loaded, rooms, task, driven.any)))


def _warnings(
    loaded: Loaded[Places], rooms: Collection[PlaceRoom], task: Task, any_driven: bool
) -> Iterator[Finding]:
    for room in rooms:
        if room.way.route is not None:  # tasks share their places: an unused one is only a warning
            continue
        if not room.used:
            words = f"no action uses the place {room.name!r}; {room.way.reason}"
            yield loaded.finding((PLACES_KEY, room.name), words, at_key=True)
        elif not room.driven_to and (any_driven or not room.way.fits):
            yield _cant(loaded, room, task)


def _cant(loaded: Loaded[Places], room: PlaceRoom, task: Task) -> Finding:
    if not room.way.fits:
        words = f"the robot can't stand at the place {room.name!r}: {room.way.reason}"
    else:
        start = _start_of(task)
        words = (
            f"no way leads to the place {room.name!r}{f' from {start!r}' if start else ''}: {room.way.reason}"
        )
        words += "" if ";" in words or "needed" in words else "; needed: a way on the map"
    return loaded.finding((PLACES_KEY, room.name), words, at_key=True)


def _start_of(task: Task) -> str | None:
    is_named = task.file.knowledge is not None and task.knowledge.is_start_known
    return task.file.knowledge.start if is_named and task.file.knowledge else None


def _named(actions: Collection[Action], driving: bool = False) -> _Named:
    """Return the places that the parameters of actions name; with `driving`, only of actions that drive the
    base.
    """
    names: set[str] = set()
    late = False
    for action in actions:
        if action.binding is None or (driving and Base not in action.binding.kind.needs):
            continue
        binding = action.binding
        asked = [
            name for name, field in binding.kind.model_fields.items() if named_entry(field) == PLACES_KEY
        ]
        late = late or any(name in binding.late for name in asked)
        names |= {str(binding.fixed.get(name)) for name in asked}
    return _Named(names, late)


def _rounded(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None


def _rounded_point(point: tuple[float, float]) -> list[float | None]:
    return [_rounded(point[0]), _rounded(point[1])]
