"""Preparation of a task: everything is checked, the robot could start, and nothing has moved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import UnknownBackend, backend_class, backend_names, check_world, make_backend
from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError, Finding, InputError
from handcart.files.findings import Findings
from handcart.files.maps.map_file import read_occupancy
from handcart.files.stages import begin_stage
from handcart.files.suggest import suggest
from handcart.networks.graph.network import ActionNetwork
from handcart.primitives.knowledge.map_masks import keepout_findings, load_speed_limits
from handcart.primitives.knowledge.place import load_map
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.registry import primitive_class
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.maps.keepout import with_keepout
from handcart.robotics.numerics.compiling_before import compile_before

from .hidden_faults import files_of, with_hidden
from .named_files import SPEED_MASK_KEYS
from .place_room import ComputedPlace, PlaceRoom, PlaceRooms, place_findings, place_rooms
from .pose_forecast import pose_findings
from .task_file import Primitives, Task, load_task
from .unknown_start import check_located, drawn_pose, start_findings
from .without_map import is_without_map, open_floor, started_exactly

T = TypeVar("T")


@dataclass(frozen=True)
class Prepared:
    """A task with robot, world model and backend, ready to run.

    It is a context manager, which closes the backend at its end.
    """

    task: Task
    backend_name: str
    backend: Backend
    robot: Robot
    model: WorldModel
    seed: int
    settings: Mapping[str, str]
    warnings: tuple[str, ...]
    """Warnings for the user before the start."""
    errors: bool = True
    """True if the simulated robot errs."""
    bench: str | None = None
    """Name of the simulated backend behind simulated drives; None without these."""

    def __enter__(self) -> Prepared:
        return self

    def __exit__(self, *_: object) -> None:
        self.backend.close()


class UnknownSituation(InputError):
    """Error: a run cannot begin in a situation that the network lacks."""


def beginning_at(network: ActionNetwork, situation: str) -> ActionNetwork:
    """Return the network with another situation as its start.

    Raises:
        UnknownSituation: the network does not have the situation.
    """
    if situation not in network.situations:
        raise UnknownSituation(f"unknown situation {situation!r}{suggest(situation, network.situations)}")
    return replace(network, start=situation)


def prepare(
    task_path: Path | str,
    backend: str | None = None,
    settings: Mapping[str, str] | None = None,
    seed: int = 0,
    primitives: Primitives = primitive_class,
    window: bool = False,
    situation: str | None = None,
    errors: bool = True,
    bench: str | None = None,
    resumed: bool = False,
) -> Prepared:
    """Read and check a task with all its files, and build its robot.

    Args:
        task_path: the task's file.
        backend: name of the backend; None: the one that the task names.
        settings: values of `--set KEY=VALUE`, VALUE unparsed.
        seed: seed of the simulated errors.
        primitives: lookup of a primitive's class by its name.
        window: True to show robot and world.
        situation: situation in which the run begins, instead of the task's start.
        errors: True if the simulated robot has the sensor and motion errors in its file, False for none.
        bench: name of a simulated backend, to be driven through simulated motor drives with the protocol of
            the real ones; None: no such drives.
        resumed: True to resume a run: the robot is where that run left it, not at the task's start.

    Raises:
        NoBench: the backend has no drives, or cannot be behind a bench.
        UnknownSituation: the task has no such situation.
        NotLocated: the start pose is unknown, and no way leads from that situation to LOCATE.
        NoWindow: robot and world cannot be shown.
        FileError: a file has faults; the error lists the faults of all files.
    """
    read = _read(task_path, backend, settings, primitives, situation, errors, resumed)
    return _built(read, settings, seed, window, errors, bench)


def _built(
    read: _Read,
    settings: Mapping[str, str] | None,
    seed: int,
    window: bool = False,
    errors: bool = True,
    bench: str | None = None,
) -> Prepared:
    """Return the prepared robot of a task that was read.

    Args:
        read: the task with all its files.
        settings: values of `--set KEY=VALUE`, VALUE unparsed.
        seed: seed of the simulated errors.
        window: True to show robot and world.
        errors: True if the simulated robot errs as its file says.
        bench: name of the simulated backend behind simulated drives; None without these.

    Raises:
        NoBench: the backend has no drives, or cannot be behind a bench.
        NoWindow: robot and world cannot be shown.
        FileError: with every finding in the files.
    """
    task, name, spec, known = read.task, read.backend, read.spec, read.known
    findings, world = read.findings, read.world
    findings.add(*read.rooms.errors)
    made = None
    if spec is not None and world is not None and known is not None and not findings:
        start = task.knowledge.start
        if not task.knowledge.is_start_known:
            start = drawn_pose(known[0].map, spec.footprint_radius_m, seed)
        if bench is None and backend_class(name).has_drives:
            compile_before()  # a real robot would be late, and blind meanwhile
        made = _collected(findings, lambda: make_backend(name, spec, world, seed, start, window, bench))
    findings.raise_all()
    assert made is not None
    assert spec is not None
    assert known is not None
    model = known[0]
    warnings = (*spec.warnings, *known[1], *_section_warnings(model), *made.remarks)
    try:
        task.check_capabilities(made, model)
        robot = make_robot(task, made, spec, model)
    except BaseException:
        made.close()
        raise
    return Prepared(task, name, made, robot, model, seed, dict(settings or {}), warnings, errors, bench)


@dataclass(frozen=True)
class _Read:
    """A task with all its files, as far as they could be read."""

    task: Task
    backend: str
    """Name of the backend."""
    spec: RobotFile | None
    known: tuple[WorldModel, tuple[str, ...]] | None
    world: Path | None
    findings: Findings
    rooms: PlaceRooms


class Checked(NamedTuple):
    """Results of checking a task without a robot: its warnings, and facts and errors about its places."""

    task: Task
    warnings: tuple[str, ...]
    """Warnings for the user before the start."""
    places: tuple[PlaceRoom, ...]
    """Checks of each place of its map."""
    errors: tuple[Finding, ...]
    """Places that an action drives to, and that cannot be reached: a run is refused."""
    computed: tuple[ComputedPlace, ...]
    """Places that no file has, because domains compute them for the robot."""

    def place_lines(self) -> Iterator[str]:
        """Yield a line of text for each place: with clearance and route, or for a computed place its pose."""
        yield from (place.words() for place in self.places)
        yield from (place.words() for place in self.computed)


def _read(
    task_path: Path | str,
    backend: str | None,
    settings: Mapping[str, str] | None,
    primitives: Primitives,
    situation: str | None,
    errors: bool,
    resumed: bool = False,
    only_looked: bool = False,
) -> _Read:
    try:
        task = load_task(task_path, settings, primitives)
    except FileError as error:
        raise with_hidden(error, lambda: files_of(task_path, settings, primitives)) from None
    if situation is not None:
        task = replace(task, network=beginning_at(task.network, situation))
        if not resumed and not task.knowledge.is_start_known:
            check_located(task.network, situation)
    findings, name = Findings(), backend or task.file.backend
    spec = _collected(findings, lambda: _robot_of(task, only_looked or _has_drives(name)))
    spec = spec if errors or spec is None else spec.without_errors()
    if spec is not None and is_without_map(task.document):
        spec = started_exactly(spec)
    known = _collected(findings, lambda: load_model(task))
    if backend is None and name not in backend_names():
        findings.add(task.document.finding(("backend",), str(UnknownBackend(name))))
    world = task.path("world")
    if world is None:
        findings.add(
            task.document.finding((), f"the key 'world' is missing; needed: the world that {name} builds")
        )
    if spec is not None and known is not None:
        for section in task.knowledge.sections.values():
            findings.add(*section.faults(spec))
        if not findings:
            findings.add(*known[0].fit(spec))
    if spec is not None and spec.drive.kind == "ackermann":
        for key in ("keepout", "speed_limits"):
            if task.document.root.deepest(("knowledge", key))[1]:
                wrong = f"{key}: a car-like base plans without a map; allowed: a base that turns on the spot"
                findings.add(task.document.finding(("knowledge", key), wrong))
    if spec is not None and (wrong := _drive_fault(name, spec)):
        findings.add(task.document.finding(("robot",), wrong))
    if spec is not None and not task.knowledge.is_start_known:
        findings.add(*start_findings(task.document, spec, task.path("knowledge", "map") is not None))
    if spec is not None and known is not None and world is not None and not resumed:
        start, grid = _stated_start(task, known[0]), known[0].map if task.path("knowledge", "map") else None
        _collected(findings, lambda: check_world(world, spec, start, grid))
    rooms = PlaceRooms()
    if spec is not None and known is not None and not findings:
        rooms = place_rooms(task, spec, known[0], task.knowledge.start)
    return _Read(task, name, spec, known, world, findings, rooms)


def _robot_of(task: Task, drives: bool) -> RobotFile:
    begin_stage(f"robot {task.robot}")
    return load_robot(task.robot, drives)


def _drive_fault(name: str, spec: RobotFile) -> str:
    """Return why a backend cannot drive a robot; "" if it can, or cannot be loaded."""
    try:
        kinds = backend_class(name).drive_kinds
    except InputError:
        return ""
    if spec.drive.kind in kinds:
        return ""
    allowed = ", ".join(sorted(kinds))
    return f"the backend {name!r} drives no {spec.drive.kind} base; allowed with it: {allowed}"


def _has_drives(name: str) -> bool:
    """Return whether a backend has CAN drives; True for one that cannot be loaded."""
    try:
        return backend_class(name).has_drives
    except InputError:
        return True


def check(
    task_path: Path | str,
    backend: str | None = None,
    settings: Mapping[str, str] | None = None,
    seed: int = 0,
    situation: str | None = None,
) -> Checked:
    """Read and check a task with all its files, without a connection to a robot.

    Args:
        task_path: the task's file.
        backend: name of the backend; None: the one that the task names.
        settings: values of `--set KEY=VALUE`, VALUE unparsed.
        seed: seed of the simulated errors.
        situation: situation in which a run would begin, instead of the task's start.

    Raises:
        UnknownSituation: the task has no such situation.
        NotLocated: the start pose is unknown, and no way leads from that situation to LOCATE.
        FileError: a file has faults; the error lists those of all files, except faults of places, which are
            returned.
    """
    read = _read(task_path, backend, settings, primitive_class, situation, True, only_looked=True)
    if read.spec is None or read.known is None or read.findings:
        read.findings.raise_all()
    assert read.spec is not None
    assert read.known is not None
    if (kinds := backend_class(read.backend).kinds(read.spec)) is None and not read.rooms.errors:
        with _built(read, settings, seed) as prepared:
            return _checked(replace(read, task=prepared.task))
    if kinds is not None:
        read.task.check_kinds(kinds, read.known[0])
    return _checked(read)


def _section_warnings(model: WorldModel) -> Iterator[str]:
    return (str(finding) for section in model.sections.values() for finding in section.warnings())


def _checked(read: _Read) -> Checked:
    robot = read.spec.warnings if read.spec else ()
    poses = (
        pose_findings(read.task, read.spec, read.known[0], read.rooms.places)
        if read.spec and read.known
        else ()
    )
    known = (*read.known[1], *_section_warnings(read.known[0])) if read.known else ()
    warnings = (*robot, *known, *map(str, read.rooms.warnings), *map(str, poses))
    places = read.known[0].places if read.known else {}
    given = read.task.knowledge.all_places()
    computed = tuple(ComputedPlace(name, places[name].pose) for name in places if name not in given)
    return Checked(read.task, warnings, read.rooms.places, read.rooms.errors, computed)


def make_robot(task: Task, backend: Backend, spec: RobotFile, model: WorldModel) -> Robot:
    """Return the robot of a task, whose pose estimate begins at the task's start if this pose is known."""
    grid = model.map if task.file.knowledge else None
    start = task.knowledge.start if task.knowledge.is_start_known else None
    return Robot(backend, spec, start, grid, is_start_exact=is_without_map(task.document))


def _stated_start(task: Task, model: WorldModel) -> Pose2 | None:
    """Return map_T_base of the start that the task states; None if it states none."""
    named = task.file.knowledge.start if task.file.knowledge else None
    return model.places[named].pose if named and named in model.places else None


def load_model(task: Task) -> tuple[WorldModel, tuple[str, ...]]:
    """Return the robot's prior knowledge, and warnings on it; raises `FileError` with every finding."""
    begin_stage("map and knowledge")
    findings, named = Findings(), task.knowledge.places
    chart, keepout, mask = (
        task.path("knowledge", "map"),
        task.path("knowledge", "keepout"),
        task.path(*SPEED_MASK_KEYS),
    )
    loaded = _collected(findings, lambda: load_map(chart)) if chart else (_floor_of(task), None)
    zones = _collected(findings, lambda: read_occupancy(keepout).grid) if keepout else None
    spec = task.file.knowledge.speed_limits if task.file.knowledge else None
    limits = _collected(findings, lambda: load_speed_limits(mask, spec)) if mask and spec else None
    for key in ("keepout", "speed_limits"):
        if not chart and task.document.root.deepest(("knowledge", key))[1]:
            wrong = f"{key} is a mask over a map; needed: the key `map`"
            findings.add(task.document.finding(("knowledge", key), wrong))
    if keepout and zones is not None and loaded:
        findings.add(*(keepout_findings(named, loaded[0], zones, keepout) if named else ()))
        loaded = with_keepout(loaded[0], zones), loaded[1]
    if chart and loaded and named:
        findings.add(*place_findings(named, loaded[0], chart))
    findings.raise_all()
    assert loaded is not None
    grid, warning = loaded
    sections = task.knowledge.fresh_sections()
    model = WorldModel(grid, task.knowledge.all_places(), speed_limits=limits, sections=sections)
    return model, (warning,) if warning else ()


def _floor_of(task: Task) -> GridMap:
    """Return the map of free floor on which a task without a map drives."""
    if not is_without_map(task.document):
        return nowhere()
    return open_floor(place.pose for place in task.knowledge.all_places().values())


def nowhere() -> GridMap:
    """Return a map of one free cell, used by tasks without a map."""
    nothing = np.zeros((1, 1), dtype=np.bool_)
    return GridMap(nothing, ~nothing, 0.05, 0.0, 0.0)


def _collected(findings: Findings, read: Callable[[], T]) -> T | None:
    try:
        return read()
    except FileError as error:
        findings.take(error)
        return None
