"""A network as a behaviour in a real py_trees tree."""

from collections import deque
from typing import Any

import py_trees
import pytest
from py_trees.common import Status

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.network_behaviour import NetworkBehaviour
from handcart.networks.events.events import Ended, Event, Started
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from tests.networks.conftest import Stand


class Alarm(py_trees.behaviour.Behaviour):
    """Keeps the tree to itself while it rings."""

    rings = False

    def update(self) -> Status:
        return Status.RUNNING if self.rings else Status.FAILURE


def tree_of(stand: Stand, network: ActionNetwork) -> tuple[Any, NetworkBehaviour, Alarm, list[Event]]:
    events: list[Event] = []
    behaviour = NetworkBehaviour(
        "network",
        stand.robot,
        lambda: Coordinator(network, stand.robot, stand.model, observers=[events.append]),
    )
    alarm = Alarm("alarm")
    root = py_trees.composites.Selector("root", memory=False, children=[alarm, behaviour])
    return py_trees.trees.BehaviourTree(root), behaviour, alarm, events


def tick(tree: Any, stand: Stand, times: int) -> None:
    for _ in range(times):
        tree.tick()
        stand.robot.step()
        if tree.root.status is not Status.RUNNING:
            return


def status(tree: Any) -> Status:
    now: Status = tree.root.status
    return now


def drive(stand: Stand, attempts: int = 3) -> ActionNetwork:
    bound = Binding.of(stand.Drive(periods=40))
    action = Action("a", "z", bound, 1.0, attempts)
    return ActionNetwork.build([Situation("a"), Situation("z")], [action], "a", "z")


def test_reaches_the_goal(stand: Stand) -> None:
    tree, behaviour, _, _ = tree_of(stand, drive(stand))
    tick(tree, stand, 200)
    assert tree.root.status is Status.SUCCESS
    assert behaviour.end is not None
    assert behaviour.end.outcome == "Success"
    assert stand.robot.pose.x == pytest.approx(0.4, abs=0.02)


def test_interrupted_it_stops_and_then_restores_first(stand: Stand) -> None:
    tree, behaviour, alarm, events = tree_of(stand, drive(stand))
    tick(tree, stand, 30)
    alarm.rings = True
    tick(tree, stand, 1)
    stopped = stand.robot.pose
    assert stopped.x > 0.1
    tick(tree, stand, 20)
    assert stand.robot.pose == stopped
    assert stand.backend.stops
    alarm.rings = False
    nearest = []
    for _ in range(400):
        tick(tree, stand, 1)
        nearest.append(stand.robot.pose.x)
        if tree.root.status is not Status.RUNNING:
            break
    assert min(nearest) < 0.02
    assert tree.root.status is Status.SUCCESS
    assert behaviour.end is not None
    assert behaviour.end.fails == 0
    assert [type(event).__name__ for event in events][:4] == ["Planned", "Started", "Restoring", "Ended"]


def test_interruptions_do_not_use_up_the_attempts_of_an_action(stand: Stand) -> None:
    tree, behaviour, alarm, events = tree_of(stand, drive(stand, attempts=1))
    for number in range(1, 4):
        for _ in range(200):
            if any(isinstance(event, Started) and event.number == number for event in events):
                break
            tick(tree, stand, 1)
        tick(tree, stand, 20)
        alarm.rings = True
        tick(tree, stand, 1)
        alarm.rings = False
    tick(tree, stand, 400)
    assert tree.root.status is Status.SUCCESS
    assert behaviour.end is not None
    assert (behaviour.end.outcome, behaviour.end.fails, behaviour.end.cause) == ("Success", 0, "")
    assert [event.number for event in events if isinstance(event, Ended)] == [1, 2, 3, 4]


def test_no_way_left_is_failure(stand: Stand) -> None:
    stand.script["x"] = deque("P")
    tree, behaviour, _, _ = tree_of(stand, stand.network("a z x 1"))
    tick(tree, stand, 5)
    assert tree.root.status is Status.FAILURE
    assert behaviour.end is not None
    assert behaviour.end.exit_status == 3


def test_give_up_stays_until_a_person_acknowledges(stand: Stand) -> None:
    stand.script["x"] = deque("G")
    tree, behaviour, _, events = tree_of(stand, stand.network("a z x 1"))
    tick(tree, stand, 1)
    before = len(events)
    tick(tree, stand, 1)
    tick(tree, stand, 1)
    assert status(tree) is Status.FAILURE
    assert behaviour.latched
    assert len(events) == before
    behaviour.acknowledge()
    tick(tree, stand, 1)
    assert status(tree) is Status.SUCCESS


def test_shutdown_while_it_runs(stand: Stand) -> None:
    tree, _, _, _ = tree_of(stand, drive(stand))
    tick(tree, stand, 10)
    tree.shutdown()
    assert stand.backend.stops


def test_ticks_after_a_shutdown_do_not_move_the_robot(stand: Stand) -> None:
    tree, network, _, _ = tree_of(stand, drive(stand))
    tick(tree, stand, 10)
    tree.shutdown()
    travel = stand.backend.wheels.travel
    network.tick_once()
    assert network.status is Status.FAILURE
    stand.robot.step()
    assert stand.backend.wheels.travel == travel
