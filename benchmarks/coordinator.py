"""Measure the coordinator's time per action, with instant primitives, beside py_trees and transitions.

    python benchmarks/coordinator.py [--actions 1000] [--rounds 7]

Every START and RESULT goes into the journal (unsynced) before it is acted on, and so does each PLAN. CPU
seconds, the minimum of some rounds: disturbances only make a round slower.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import ClassVar

import numpy as np
import py_trees
from transitions import Machine

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.graph.planner import Planner
from handcart.networks.journal.journal import Journal
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

DRIVE_SPEC = {
    "wheel_radius_m": 0.1,
    "tread_m": 0.4,
    "top_speed_m_s": 1.0,
    "top_turn_deg_s": 90.0,
    "acceleration_m_s2": 1.0,
    "turn_acceleration_deg_s2": 180.0,
}
TOLERANCE_SPEC = {"base_mm": 25, "base_deg": 1.5, "joints_deg": 0.3, "gripper_mm": 1, "object_mm": 8}
ROBOT_SPEC = {
    "format": "handcart-robot/1",
    "urdf": "none.urdf",
    "period_s": 0.05,
    "footprint_radius_m": 0.3,
    "localizer": "odometry",
    "drive": DRIVE_SPEC,
    "tolerance": TOLERANCE_SPEC,
}


class Standing(Base):
    """Wheels that never roll."""

    def drive(self, speed: float, turn_rate: float) -> None:
        return

    def wheel_travel(self) -> WheelTravel:
        return WheelTravel(0.0, 0.0)


class Nothing(Backend):
    """A robot that does nothing."""

    name = "nothing"
    period = 0.05

    def __init__(self) -> None:
        self._wheels = Standing()

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Nothing:
        return cls()

    def capabilities(self) -> tuple[Capability, ...]:
        return (self._wheels,)

    def step(self) -> None:
        return

    def stop(self) -> None:
        return

    def close(self) -> None:
        return


class Instant(ActionPrimitive):
    """Succeeds before a period has passed."""

    number: int
    only_knowledge: ClassVar[bool] = True

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


def chain(length: int) -> ActionNetwork:
    """Return a network that is one long way."""
    situations = [Situation(f"s{number}") for number in range(length + 1)]
    actions = [
        Action(f"s{number}", f"s{number + 1}", Binding.of(Instant(number=number))) for number in range(length)
    ]
    return ActionNetwork.build(situations, actions, "s0", f"s{length}")


def coordinator_round(network: ActionNetwork, journal: Journal | None) -> float:
    """Seconds for one run through the network."""
    nothing = np.zeros((1, 1), dtype=np.bool_)
    model = WorldModel(GridMap(nothing, nothing, 0.05, 0.0, 0.0), {})
    robot = Robot(Nothing(), RobotFile.model_validate(ROBOT_SPEC), Pose2(0.0, 0.0, 0.0))
    coordinator = Coordinator(network, robot, model, journal)
    began = process_time()
    for _ in coordinator.run():
        robot.step()
    taken = process_time() - began
    assert coordinator.situation == network.goal
    return taken


def journaled_round(network: ActionNetwork) -> float:
    """Run the same round with a journal on the disk."""
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "journal.jsonl") as journal:
        return coordinator_round(network, journal)


def planning_s(situations: int) -> float:
    """Seconds for one plan over three times as many actions."""
    names = [f"s{number}" for number in range(situations)]
    bound = Binding.of(Instant(number=0))
    actions = [
        Action(name, names[(number + step) % situations], bound)
        for number, name in enumerate(names)
        for step in (1, 7, 113)
    ]
    planner = Planner(ActionNetwork.build(map(Situation, names), actions, names[0], names[-1]))
    began = process_time()
    planner.plan(names[0])
    return process_time() - began


def py_trees_round(length: int) -> float:
    """Seconds for one tick of a sequence of as many instant behaviours."""
    steps: list[py_trees.behaviour.Behaviour] = [py_trees.behaviours.Success(f"s{n}") for n in range(length)]
    tree = py_trees.trees.BehaviourTree(py_trees.composites.Sequence("all", memory=True, children=steps))
    began = process_time()
    tree.tick()
    taken = process_time() - began
    assert tree.root.status is py_trees.common.Status.SUCCESS
    return taken


def transitions_round(length: int) -> float:
    """Seconds for as many steps of a state machine."""
    machine = Machine(states=["a", "b"], initial="a", auto_transitions=False)
    machine.add_transition("go", "a", "b")
    machine.add_transition("go", "b", "a")
    step = machine.go
    began = process_time()
    for _ in range(length):
        step()
    return process_time() - began


def least_us(work: Callable[[], float], length: int, rounds: int) -> float:
    """Return the least of some rounds, per action in [us]."""
    return 1e6 * min(work() for _ in range(rounds)) / length


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--actions", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=7)
    chosen = parser.parse_args()
    length, rounds = chosen.actions, chosen.rounds
    network = chain(length)
    rows = {
        "handcart, journal on": least_us(lambda: journaled_round(network), length, rounds),
        "handcart, no journal": least_us(lambda: coordinator_round(network, None), length, rounds),
        "py_trees, Sequence": least_us(lambda: py_trees_round(length), length, rounds),
        "transitions, one step": least_us(lambda: transitions_round(length), length, rounds),
    }
    first = next(iter(rows.values()))
    print(f"{length} instant primitives, least of {rounds} rounds")
    for name, taken in rows.items():
        print(f"{name:24s} {taken:8.1f} us an action   {taken / first:6.2f} of the first")
    for situations in (10, 1_000, 33_000):
        print(f"one plan over {3 * situations:6d} actions: {1e3 * planning_s(situations):8.2f} ms")


if __name__ == "__main__":
    main()
