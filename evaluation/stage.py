"""A robot in a world, to try single primitives on."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Literal

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.registry import make_backend
from handcart.backends.robot import MissingCapability, Robot
from handcart.backends.robot_loading import load_robot
from handcart.files.errors import InputError
from handcart.files.loading import load
from handcart.files.suggest import suggest
from handcart.networks.task_file import Task
from handcart.primitives.action_primitive import ActionPrimitive
from handcart.primitives.attempt import attempt
from handcart.primitives.building import Building
from handcart.primitives.knowledge import Catalogue, load_map
from handcart.primitives.outcome import Outcome
from handcart.primitives.place_file import load_places
from handcart.primitives.world_model import WorldModel

NO_BOOKS: Literal["handcart-catalogue/1"] = "handcart-catalogue/1"
LIBRARY = Path(__file__).parent.parent / "tasks" / "return_book"


class NoSuchPlace(InputError):
    """The robot can't start at a place that isn't there."""


@dataclass(frozen=True)
class StageFiles:
    """What a stage is built from; by default the library of the task return_book."""

    world: Path = LIBRARY / "world.yaml"
    map: Path = LIBRARY / "map.yaml"
    places: Path = LIBRARY / "places.yaml"
    catalogue: Path | None = LIBRARY / "catalogue.yaml"
    building: Path | None = None
    start: str = "home"
    """The place where the robot stands at first."""


def files_of(task: Task) -> StageFiles:
    """What a task with a map and places is run with."""
    world, grid, places = task.path("world"), task.path("knowledge", "map"), task.path("knowledge", "places")
    assert world is not None
    assert grid is not None
    assert places is not None
    catalogue, building = (task.path("knowledge", name) for name in ("catalogue", "building"))
    start = task.file.knowledge.start if task.file.knowledge else StageFiles.start
    return StageFiles(world, grid, places, catalogue, building, start or StageFiles.start)


@dataclass
class Stage:
    """A robot in a world, with what it is told beforehand; leaving it as a context closes the backend."""

    robot: Robot
    model: WorldModel
    backend: Backend
    restored: list[str] = field(default_factory=list)
    """Why restoring began, each time that it did."""

    def do(self, primitive: ActionPrimitive) -> Outcome:
        """One attempt of a primitive, to its outcome.

        Raises:
            MissingCapability: the robot lacks what the primitive needs; nothing has moved.
        """
        for kind in primitive.needs:
            if self.backend.get(kind) is None:
                raise MissingCapability(kind, self.backend)
        periods = attempt(primitive, self.robot, self.model, self.restored.append)
        while True:
            try:
                next(periods)
            except StopIteration as end:
                outcome: Outcome = end.value
                return outcome
            self.robot.step()

    def __enter__(self) -> Stage:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.backend.close()


def set_stage(
    files: StageFiles = StageFiles(), robot: str = "librarian", backend: str = "kinematic", seed: int = 0
) -> Stage:
    """Build a stage.

    Args:
        files: world and knowledge.
        robot: a shipped robot's name, or the path of a robot's YAML file.
        backend: by name.
        seed: of the simulated errors.

    Raises:
        FileError: something in the files is wrong.
    """
    spec = load_robot(robot)
    places = load_places(files.places).value.places
    if files.start not in places:
        raise NoSuchPlace(f"no place {files.start!r} to start at{suggest(files.start, places)}")
    grid, _ = load_map(files.map)
    books = load(files.catalogue, Catalogue) if files.catalogue else Catalogue(format=NO_BOOKS, books=())
    plan = load(files.building, Building) if files.building else None
    model = WorldModel(grid, places, books, np.empty((0, 2)), building=plan)
    start = places[files.start].pose
    made = make_backend(backend, spec, files.world, seed, start)
    return Stage(Robot(made, spec, start, grid), model, made)
