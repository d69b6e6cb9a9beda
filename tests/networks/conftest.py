"""A robot with only two wheels, and primitives that end as the test says."""

from collections import deque
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

SPEC = {
    "format": "handcart-robot/1",
    "urdf": "none.urdf",
    "period_s": 0.05,
    "footprint_radius_m": 0.3,
    "localizer": "odometry",
    "drive": {
        "wheel_radius_m": 0.1,
        "tread_m": 0.4,
        "top_speed_m_s": 1.0,
        "top_turn_deg_s": 90.0,
        "acceleration_m_s2": 1.0,
        "turn_acceleration_deg_s2": 180.0,
    },
    "tolerance": {"base_mm": 300, "base_deg": 10, "joints_deg": 1, "gripper_mm": 1, "object_mm": 8},
}


class Wheels(Base):
    """Wheels that roll exactly as commanded."""

    def __init__(self) -> None:
        self.command = (0.0, 0.0)
        self.travel = WheelTravel(0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        self.command = (speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        return self.travel


class TwoWheels(Backend):
    """A robot with wheels alone."""

    name = "two_wheels"
    period = 0.05

    def __init__(self) -> None:
        self.wheels = Wheels()
        self.stops = 0

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> "TwoWheels":
        return cls()

    def capabilities(self) -> tuple[Capability, ...]:
        return (self.wheels,)

    def step(self) -> None:
        (speed, turn), self.wheels.command = self.wheels.command, (0.0, 0.0)
        left, right, _ = self.wheels.travel
        self.wheels.travel = WheelTravel(
            left + 0.05 * (speed - 0.2 * turn), right + 0.05 * (speed + 0.2 * turn)
        )

    def stop(self) -> None:
        self.stops += 1
        self.wheels.command = (0.0, 0.0)

    def close(self) -> None:
        pass


class Think(ActionPrimitive):
    """Ends at once, in the way that its script says next; Success when that is used up."""

    name: str
    text: str = ""
    only_knowledge: ClassVar = True
    script: ClassVar[dict[str, deque[str]]] = {}

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        left = self.script.get(self.name)
        match left.popleft() if left else "S":
            case "F":
                raise Discrepancy(f"{self.name} failed")
            case "P":
                raise Discrepancy(f"{self.name} can't be", permanent=True)
            case "G":
                raise NeedsPerson(f"{self.name} needs help")
        return
        yield


class Drive(ActionPrimitive):
    """Drives on for a number of periods."""

    periods: int = 40
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(self.periods):
            robot.base.drive(0.2, 0.0)
            yield


@dataclass
class Stand:
    """All that a test of the coordinator needs."""

    backend: TwoWheels
    robot: Robot
    model: WorldModel
    script: dict[str, deque[str]] = field(default_factory=lambda: Think.script)
    Think: type[Think] = Think
    Drive: type[Drive] = Drive

    def driving(self, periods: int = 40) -> ActionNetwork:
        """Return a network of one action, which drives for some periods."""
        bound = Binding.of(self.Drive(periods=periods))
        return ActionNetwork.build([Situation("a"), Situation("z")], [Action("a", "z", bound, 1.0)], "a", "z")

    def network(self, *rows: str, start: str = "a", goal: str = "z") -> ActionNetwork:
        """Actions as `from to name cost [attempts [on_fail]]`; situations as they are named."""
        names: dict[str, None] = {start: None}
        actions = []
        for row in rows:
            source, target, name, cost, *more = row.split()
            names |= {source: None, target: None}
            on_fail = more[1] if len(more) > 1 else None
            if on_fail:
                names[on_fail] = None
            bound = Binding.of(Think(name=name))
            attempts = int(more[0]) if more else 3
            actions.append(Action(source, target, bound, float(cost), attempts, on_fail))
        names[goal] = None
        return ActionNetwork.build(map(Situation, names), actions, start, goal)

    def finish(
        self, coordinator: Coordinator, at: Mapping[int, Callable[[], object]] | None = None
    ) -> RunEnd:
        """Step the robot until the run ends; `at` maps periods to what happens then."""
        return drain(coordinator, self.robot, at or {})


def drain(coordinator: Coordinator, robot: Robot, at: Mapping[int, Callable[[], object]]) -> RunEnd:
    run: Generator[None, None, RunEnd] = coordinator.run()
    for period in range(100_000):
        if period in at:
            at[period]()
        try:
            next(run)
        except StopIteration as end:
            ended: RunEnd = end.value
            return ended
        robot.step(coordinator.life.paused)
    raise AssertionError("the run doesn't end")


def make_stand() -> Stand:
    Think.script = {}
    empty = np.zeros((2, 2), dtype=np.bool_)
    model = WorldModel(GridMap(empty, empty, 0.05, 0.0, 0.0), {})
    backend = TwoWheels()
    robot = Robot(backend, RobotFile.model_validate(SPEC), Pose2(0.0, 0.0, 0.0))
    return Stand(backend, robot, model, Think.script)


@pytest.fixture
def stand() -> Stand:
    return make_stand()


@pytest.fixture
def new_stand() -> Callable[[], Stand]:
    """Return a factory of stands, used by tests that need more than one."""
    return make_stand


@pytest.fixture
def primitives() -> SimpleNamespace:
    return SimpleNamespace(THINK=Think, DRIVE=Drive)


@pytest.fixture
def load(tmp_path: Path, primitives: SimpleNamespace) -> Callable[..., Task]:
    """Reads the text of a task file, with settings."""

    def primitive(name: str) -> type[ActionPrimitive]:
        if not hasattr(primitives, name):
            raise KeyError(f"unknown primitive {name!r}; allowed: THINK, DRIVE")
        kind: type[ActionPrimitive] = getattr(primitives, name)
        return kind

    def loaded(text: str, **settings: str) -> Task:
        path = tmp_path / "lib" / "task.yaml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        return load_task(path, settings, primitive)

    return loaded
