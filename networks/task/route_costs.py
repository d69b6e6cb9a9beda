"""Costs of actions from the model: the driving time along the planned route between two places."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import InputError
from handcart.files.maps.map_file import read_occupancy
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.entries.entry import TaskEntry
from handcart.networks.graph.network import Action, Fact
from handcart.primitives.knowledge.place import Place, load_map
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.keepout import with_keepout
from handcart.robotics.navigation.routes.ways import Ways

from .named_files import named_robot, resolved
from .primitive_parameters import named_entry
from .task_knowledge import PLACES_KIND, TaskKnowledge


class NoRouteCost(InputError):
    """Error: the driving time between two places cannot be computed before the run; the message says why."""


class RouteTimes:
    """Driving times between the places of a task, along routes planned on its map for its robot.

    The files of map and robot are read at the first call of `seconds`. Without a map, and for car-like bases,
    a route is a straight line.
    """

    def __init__(self, document: Document, knowledge: TaskKnowledge) -> None:
        """Prepare the times.

        Args:
            document: the task's document.
            knowledge: its places.
        """
        self._document, self._knowledge = document, knowledge
        self._known: dict[tuple[str, str], float] = {}
        self._ways: dict[str, Ways] = {}

    def seconds(self, start: str, goal: str) -> float:
        """Return the time to drive from one place to another at the robot's top speed, in [s].

        Raises:
            NoRouteCost: a place is unknown, or no route leads there.
            FileError: the map or the robot cannot be read.
        """
        if (start, goal) not in self._known:
            from_place, to_place = self._place(start), self._place(goal)
            length = 0.0 if start == goal else self._length(start, from_place, goal, to_place)
            self._known[start, goal] = length / self._robot.drive.top_speed_m_s
        return self._known[start, goal]

    def _place(self, name: str) -> Place:
        places = self._knowledge.all_places()
        if name not in places:
            raise NoRouteCost(f"unknown place {name!r}{suggest(name, places)}")
        return places[name]

    def _length(self, start: str, from_place: Place, goal: str, to_place: Place) -> float:
        if self._grid is None or self._robot.drive.kind == "ackermann":
            return from_place.pose.distance(to_place.pose)
        if start not in self._ways:
            self._ways[start] = Ways(self._grid, self._robot.footprint_shape, from_place.pose)
        way = self._ways[start].to(to_place.pose, to_place.front if to_place.docks else None)
        if way.route is None:
            raise NoRouteCost(f"no route leads from {start!r} to {goal!r}: {way.reason}")
        return float(way.route.length)

    @cached_property
    def _robot(self) -> RobotFile:
        name, there = self._document.root.deepest(("robot",))
        return load_robot(named_robot(self._document, str(name.content) if there else ""), False)

    @cached_property
    def _grid(self) -> GridMap | None:
        chart, keepout = (resolved(self._document, ("knowledge", key)) for key in ("map", "keepout"))
        if chart is None:
            return None
        grid = load_map(chart)[0]
        return grid if keepout is None else with_keepout(grid, read_occupancy(keepout).grid)


def with_route_costs(
    actions: Sequence[Action],
    entries: Sequence[int | None],
    rows: Sequence[TaskEntry],
    facts: Mapping[str, Mapping[str, Fact]],
    times: RouteTimes,
    add: Callable[[KeyPath, str], None],
) -> list[Action]:
    """Return the actions, with the driving time to their place added to the costs of those with `route_from`.

    This key of an action's entry names the fact that states from which place the base drives.

    Args:
        actions: the actions.
        entries: number of the file's entry of each action; None if the action is generated and only skips one
            element of a `repeat` (a part of the task that is done for each element of a list).
        rows: the file's entries.
        facts: facts of each situation.
        times: driving times.
        add: called for each fault in the file, with its key in the file and a message.
    """
    found, reported = list[Action](), set[int]()
    for action, number in zip(actions, entries, strict=True):
        fact = None if number is None else rows[number].route_from
        if number is None or fact is None:
            found.append(action)
            continue
        seconds = 0.0
        try:
            seconds = _route_seconds(action, fact, facts[action.source], times)
        except NoRouteCost as wrong:
            if number not in reported:  # one copy stands for all
                reported.add(number)
                add(("actions", number, "route_from"), str(wrong))
        found.append(replace(action, cost_s=round(action.cost_s + seconds, 2)))
    return found


def _route_seconds(action: Action, fact: str, facts: Mapping[str, Fact], times: RouteTimes) -> float:
    if fact not in facts:
        wrong = f"the situation {action.source!r} has no fact {fact!r}{suggest(fact, facts)}"
        raise NoRouteCost(f"{wrong}; needed: the place of the base")
    places = list(_places_of(action))
    if not places:
        raise NoRouteCost(f"{action.do} names no place before the run; needed: a fixed place")
    return times.seconds(str(facts[fact]), places[0])


def _places_of(action: Action) -> Iterator[str]:
    """Yield the places that an action's parameters name."""
    binding = action.binding
    if binding is None:
        return
    for name, field in binding.kind.model_fields.items():
        if named_entry(field) == PLACES_KIND and name in binding.fixed:
            yield str(binding.fixed[name])
