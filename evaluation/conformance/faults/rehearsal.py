"""Runs of a task without faults, up to the attempts into which faults are injected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.rig.bench import KitBench, liar_around
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import NoWay, Planner
from handcart.networks.task.preparing import make_robot, prepare
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Success

from .faulty_backend import FaultyBackend
from .underway import Underway

TASKS_FOLDER = Path(__file__).parents[3] / "tasks"
DRIVE_MAP = TASKS_FOLDER / "drive_map" / "task.yaml"
LOCATE_TASK = TASKS_FOLDER / "drive_map" / "locate.yaml"
EXPLORE_TASK = TASKS_FOLDER / "drive_map" / "explore.yaml"


class NoRehearsal(Exception):
    """Error for a task that does not succeed although no fault was injected."""


@dataclass(frozen=True)
class Rehearsal:
    """Trial run of a task on a backend, with faults injected into the task's actions."""

    task: Path
    backend: str
    seed: int = 0
    liar: str | None = None
    """Name of the backend fault that the rehearsal plants; None: the backend as it is."""
    settings: Mapping[str, str] = field(default_factory=dict)
    """Values of the task's parameters, by name, as with `handcart run --set`."""
    instead: Mapping[str, type[ActionPrimitive]] = field(default_factory=dict)
    """Classes that replace primitives, by name of the primitive."""
    simulated: str | None = None
    """Name of the simulated backend behind the drives or topics; None: the backend needs none."""

    def actions(self) -> list[Action]:
        """Return the task's actions that the rehearsal runs: the cheapest plan to the goal, and actions that
        only compute.

        Actions that only compute move nothing; they are run if they begin in a situation of the plan.

        Raises:
            NoRehearsal: no plan leads to the goal.
        """
        return rehearsed(load_task(self.task, self.settings))

    def attempts(self) -> Iterator[tuple[int, str, Underway]]:
        """Yield for each action, in the task's order, its number (from 1), its name, and an attempt that has
        not started yet.

        If the caller has not finished an attempt, the next iteration runs it to its end.

        Raises:
            NoRehearsal: an attempt does not succeed.
        """
        with prepare(self.task, self.backend, self.settings, self.seed, bench=self.simulated) as prepared:
            inner = prepared.backend
            spec = load_robot(prepared.task.robot)
            wrapped = inner if self.liar is None else liar_around(self.liar, inner, spec)
            backend = FaultyBackend(wrapped)
            robot: Robot = make_robot(prepared.task, backend, prepared.robot.spec, prepared.model)
            for number, action in enumerate(rehearsed(prepared.task), start=1):
                assert action.binding is not None
                primitive = action.binding.make(prepared.model)
                kind = self.instead.get(action.do)
                made = primitive if kind is None else kind.model_validate(primitive.model_dump())
                underway = Underway(made, robot, backend, prepared.model, spec, self.seed)
                yield number, action.do, underway
                outcome = None
                while outcome is None:
                    outcome = underway.advance()
                if not isinstance(outcome, Success):
                    raise NoRehearsal(f"{action}: {type(outcome).__name__}: {outcome.reason}")


@dataclass(frozen=True)
class Solo:
    """Run of only one primitive, without a task, from the robot's start pose; faults are injected into it."""

    bench: KitBench
    primitive: ActionPrimitive
    seed: int = 0

    def attempts(self) -> Iterator[tuple[int, str, Underway]]:
        """Set up a robot in a new world, and yield one attempt of the primitive that has not started yet.

        The attempt comes after its number, which is 0, and the primitive's name.
        """
        with self.bench.rig(self.seed) as rig:
            faulty = FaultyBackend(rig.backend)
            robot = self.bench.around(rig, faulty).robot
            primitive = self.primitive.model_copy()
            underway = Underway(primitive, robot, faulty, rig.model, self.bench.spec(), self.seed)
            yield 0, primitive.label(), underway


def rehearsed(task: Task) -> list[Action]:
    """Return the actions of a task's cheapest plan, and the network's computing actions that may run next to
    them.

    A computing action, such as one that plans, moves nothing. It is inserted before an action X of the plan
    if it starts in the situation from which X starts, or in one to which a Fail of X leads.
    """
    network = task.network
    plan = Planner(network).plan(network.start)
    if isinstance(plan, NoWay):
        raise NoRehearsal(plan.explanation)
    result: list[Action] = []
    for action in plan.actions:
        for other in network.actions:
            thinks = other.binding is not None and other.binding.kind.only_knowledge
            here = other.source in (action.source, *action.fail_situations)
            if thinks and here and other not in plan.actions:
                result.append(other)
        result.append(action)
    return result
