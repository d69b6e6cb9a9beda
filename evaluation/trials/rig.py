"""Test rig for attempts of single primitives: a robot in a world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

from handcart.backends.backend import Backend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.robot.robot import Robot
from handcart.files.errors import InputError
from handcart.files.findings import Findings
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import Node
from handcart.networks.task.preparing import nowhere
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_knowledge import MAP_ORIGIN, TaskKnowledge, domain_keys, read_sections
from handcart.networks.task.without_map import is_without_map, open_floor, started_exactly
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.knowledge.place import load_map, load_places
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes.outcome import Outcome

LIBRARY_FOLDER = Path(__file__).parent.parent.parent / "tasks" / "return_book"


class NoSuchPlace(InputError):
    """Error for a start place of the robot that the places' file does not have."""


@dataclass(frozen=True)
class RigFiles:
    """World, map and knowledge files for a robot without a task (default: those of the task return_book)."""

    world: Path = LIBRARY_FOLDER / "world.yaml"
    map: Path | None = LIBRARY_FOLDER / "map.yaml"
    places: Path | None = LIBRARY_FOLDER / "places.yaml"
    knowledge: Mapping[str, Path] = field(
        default_factory=lambda: {"catalogue": LIBRARY_FOLDER / "catalogue.yaml"}
    )
    """Further files, by their keys under `knowledge:` of a task file."""
    start: str = "home"
    """Name of the robot's start place."""
    is_without_map: bool = False
    """True if the robot has no map on purpose: its frame is that of its start (`map: none`)."""

    @classmethod
    def without_map(cls, world: Path) -> RigFiles:
        """Return the files for a robot in a world of which it has no map, places or other knowledge."""
        return cls(world, None, None, {}, "", is_without_map=True)

    @classmethod
    def of(cls, task: Task) -> RigFiles:
        """Return the paths of the world, of the map and of other files that a task names for a simulated run.

        Raises:
            InputError: the task has no world.
        """
        world, named = task.path("world"), {key: task.path("knowledge", key) for key in domain_keys()}
        if world is None:
            raise InputError(f"{task.document.file}: the task names no world; needed: the key `world`")
        is_named = task.file.knowledge is not None and task.knowledge.is_start_known
        start = (task.file.knowledge.start if is_named and task.file.knowledge else None) or ""
        others = {key: path for key, path in named.items() if path is not None}
        is_without = is_without_map(task.document)
        map_, places = task.path("knowledge", "map"), task.path("knowledge", "places")
        return cls(world, map_, places, others, start, is_without)


@dataclass
class Rig:
    """Test set-up of a robot on a backend, in a world, with prior knowledge but without a task.

    It is a context manager that closes the backend on exit.
    """

    robot: Robot
    model: WorldModel
    backend: Backend
    knowledge: TaskKnowledge = field(default_factory=lambda: TaskKnowledge(None, {}))
    restored: list[str] = field(default_factory=list)
    """Reasons of the restorations so far, one for each."""

    def do(self, primitive: ActionPrimitive) -> Outcome:
        """Execute one attempt of a primitive and return its outcome.

        Raises:
            MissingCapability: the robot lacks a capability that the primitive needs; nothing has moved.
        """
        for kind in primitive.needs:
            self.robot.get(kind)
        periods = attempt(primitive, self.robot, self.model, self.restored.append)
        while True:
            try:
                next(periods)
            except StopIteration as end:
                outcome: Outcome = end.value
                return outcome
            self.robot.step()

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.backend.close()


def build_rig(
    files: RigFiles = RigFiles(),
    robot: str = "librarian",
    backend: str = "kinematic",
    seed: int = 0,
    put_at_start: bool = False,
    is_start_known: bool = True,
    bench: str | None = None,
) -> Rig:
    """Build a test set-up: a robot on a backend, with world, map and knowledge, but without a task.

    Args:
        files: world, map and knowledge.
        robot: name or file of the robot.
        backend: name of the backend.
        seed: seed of simulated errors.
        put_at_start: True to put the robot at the start place of `files` also if the world states another
            start.
        is_start_known: False for a robot that has to find its start pose by itself.
        bench: name of the simulated backend whose robot the drives or topics of `backend` control; None:
            `backend` needs no simulation.

    Raises:
        NoSuchPlace: the start place does not exist.
        FileError: a file is invalid.
    """
    spec, findings = load_robot(robot), Findings()
    spec = started_exactly(spec) if files.is_without_map else spec
    places = load_places(files.places) if files.places else None
    known = places.value.places if places else {}
    if files.start and files.start not in known:
        raise NoSuchPlace(f"no place {files.start!r} to start at{suggest(files.start, known)}")
    start = known[files.start].pose if files.start else MAP_ORIGIN
    where = Document(str(files.world), b"", Node({}, str(files.world), 1, 1, 1, 1))
    knowledge = TaskKnowledge(places, read_sections(files.knowledge, start, where, findings), start)
    findings.raise_all()
    poses = [place.pose for place in knowledge.all_places().values()]
    floor = open_floor(poses) if files.is_without_map else nowhere()
    grid = load_map(files.map)[0] if files.map else floor
    model = WorldModel(grid, knowledge.all_places(), sections=knowledge.fresh_sections())
    findings.add(*model.fit(spec))
    findings.raise_all()
    made = make_backend(backend, spec, files.world, seed, start, bench=bench, put_at_start=put_at_start)
    try:
        made_robot = Robot(made, spec, start if is_start_known else None, model.map, files.is_without_map)
    except BaseException:
        made.close()
        raise
    return Rig(made_robot, model, made, knowledge)
