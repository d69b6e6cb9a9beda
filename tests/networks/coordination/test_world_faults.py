"""Effects of the world and of other people on a run (rows N7 to N10, N12)."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.world_watch import WorldWatch
from handcart.networks.events.events import Ended, Event, LeftOut, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.graph.planner import Planner
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.attempt import NOT_ALONE, attempt
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp
from handcart.primitives.restoring.snapshot import residuals, take_snapshot
from tests.networks.conftest import Stand

HOME, FAR = {"base": "home", "book": "in hand"}, {"base": "far", "book": "in hand"}


class Go(ActionPrimitive):
    """Primitive that drives for two seconds, with a precondition and an outcome that the test decides."""

    needs: ClassVar = (Base,)
    unmet: ClassVar[list[str]] = []
    seen: ClassVar[bool] = True
    no_return: ClassVar[bool] = False

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        return self.unmet.pop() if self.unmet else ""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(40):
            robot.base.drive(0.5, 0.0)
            yield
        if self.no_return:
            yield from self.intend("the lamp goes out")
            self.point_of_no_return("the lamp is out")

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        return self.seen
        yield


@pytest.fixture
def go(monkeypatch: pytest.MonkeyPatch) -> type[Go]:
    monkeypatch.setattr(Go, "unmet", [])
    return Go


def line(
    go: type[Go], facts: Sequence[Mapping[str, str]] = (HOME, FAR, FAR), permit: bool = False
) -> ActionNetwork:
    """Return a network from a to b to c, with a drive for each step."""
    names = [Situation(name, fact) for name, fact in zip("abc", facts, strict=True)]
    bound = Binding.of(go())
    actions = [Action("a", "b", bound, 1.0), Action("b", "c", bound, 1.0, permit=permit)]
    return ActionNetwork.build(names, actions, "a", "c")


def push(stand: Stand, metres: float) -> None:
    """Push the robot by a distance, so that its wheels turn."""
    travel = stand.backend.wheels.travel
    stand.backend.wheels.travel = type(travel)(travel.left + metres, travel.right + metres)


def test_a_precondition_that_is_false_is_not_dispatched(stand: Stand, go: type[Go], tmp_path: Path) -> None:
    """N7: not started, counted, planned again."""
    go.unmet[:] = ["the hand is empty"]
    network = line(go)
    events: list[Event] = []
    with Journal(tmp_path / "j") as journal:
        end = stand.finish(Coordinator(network, stand.robot, stand.model, journal, observers=[events.append]))
    assert (end.outcome, end.actions, end.fails) == ("Success", 2, 1)
    assert [type(event) for event in events if isinstance(event, LeftOut | Started)] == [
        LeftOut,
        Started,
        Started,
    ]
    kinds = [record["kind"] for record in read_journal(tmp_path / "j").records]
    assert kinds[:4] == ["PLAN", "NOT_STARTED", "PLAN", "START"]


def test_what_nobody_can_be_asked_to_permit_is_not_started(stand: Stand, go: type[Go]) -> None:
    """U12"""
    events: list[Event] = []
    end = stand.finish(
        Coordinator(line(go, permit=True), stand.robot, stand.model, observers=[events.append])
    )
    assert (end.outcome, end.situation, end.actions) == ("Fail", "b", 1)
    left_out = [event for event in events if isinstance(event, LeftOut)]
    assert left_out and all(event.reason == "permission was refused" for event in left_out)


def test_a_success_that_is_not_seen_is_none(
    stand: Stand, go: type[Go], monkeypatch: pytest.MonkeyPatch
) -> None:
    """N8: restored and measured it is a Fail."""
    monkeypatch.setattr(go, "seen", False)
    events: list[Event] = []
    end = stand.finish(Coordinator(line(go), stand.robot, stand.model, observers=[events.append]))
    outcomes = [event.outcome for event in events if isinstance(event, Ended)]
    assert all(
        isinstance(outcome, Fail) and "success is not confirmed" in outcome.reason for outcome in outcomes
    )
    assert end.outcome == "Fail"
    assert abs(stand.robot.pose.x) < 0.02


def test_unseen_effect_past_no_return_is_a_give_up(
    stand: Stand, go: type[Go], monkeypatch: pytest.MonkeyPatch
) -> None:
    """N8: after a point of no return it is a GiveUp."""
    monkeypatch.setattr(go, "seen", False)
    monkeypatch.setattr(go, "no_return", True)
    end = stand.finish(Coordinator(line(go), stand.robot, stand.model))
    assert end.outcome == "GiveUp"
    assert "success is not confirmed" in end.reason


def pushed_while_asked(
    stand: Stand, network: ActionNetwork, metres: float, tmp_path: Path
) -> tuple[RunEnd, list[Event], Sequence[Mapping[str, Any]]]:
    """Run a network, and push the robot while its second action waits for permission."""
    asked = []

    def permission(action: Action) -> bool | None:
        if action.source == "b":
            asked.append(action)
            if len(asked) == 5:
                push(stand, metres)
            return True if len(asked) != 5 else None
        return True

    def answers(action: Action) -> bool | None:
        answer = permission(action)
        return None if action.source == "b" and len(asked) < 10 else answer

    events: list[Event] = []
    with Journal(tmp_path / "j") as journal:
        run = Coordinator(
            network, stand.robot, stand.model, journal, observers=[events.append], permission=answers
        )
        end = stand.finish(run)
    return end, events, read_journal(tmp_path / "j").records


def test_pushed_back_to_where_it_was_before_it_goes_on_from_there(
    stand: Stand, go: type[Go], tmp_path: Path
) -> None:
    """N9: RECON, and a plan from the situation that is observed."""
    network = line(go)
    end, events, records = pushed_while_asked(stand, network, -1.0, tmp_path)
    assert (end.outcome, end.fails, end.actions) == ("Success", 1, 3)
    recon = next(record for record in records if record["kind"] == "RECON")
    assert recon["situation"] == "a"
    assert recon["at"]["base"][0] == pytest.approx(0.0, abs=0.02)
    assert recon["expected"]["base"][0] == pytest.approx(1.0, abs=0.02)
    after = [record for record in records if record["q"] > recon["q"]]
    assert (after[0]["kind"], after[0]["situation"]) == ("PLAN", "a")
    left_out = next(event.reason for event in events if isinstance(event, LeftOut))
    assert left_out.startswith("somebody changed the world: base_mm 1e+03")


def test_the_journal_tells_the_same_way(stand: Stand, go: type[Go], tmp_path: Path) -> None:
    """N9: a resume follows the RECON too."""
    network = line(go)
    _, _, records = pushed_while_asked(stand, network, -1.0, tmp_path)
    header = {"kind": "RUN", "network": network.fingerprint()}
    recon = next(record["q"] for record in records if record["kind"] == "RECON")
    there = standing(network, [header, *records[: recon + 1]])
    assert (there.route.situation, there.fails) == ("a", 1)
    assert standing(network, [header, *records]).route.arrived


def test_pushed_to_where_it_never_was_it_asks_for_a_person(
    stand: Stand, go: type[Go], tmp_path: Path
) -> None:
    """N9: no situation that the run was in fits."""
    end, _, records = pushed_while_asked(stand, line(go), 0.5, tmp_path)
    assert end.outcome == "GiveUp"
    assert "somebody changed the world: base_mm 500" in end.reason
    assert [record["kind"] for record in records[-2:]] == ["RECON", "END"]
    assert records[-2]["situation"] is None


def test_a_changed_world_stops_the_robot(stand: Stand, go: type[Go], tmp_path: Path) -> None:
    """N9: before a person is asked for."""
    stops = []

    def note(event: Event) -> None:
        if isinstance(event, LeftOut):
            stops.append(stand.backend.stops)

    asked = []

    def permission(action: Action) -> bool | None:
        if action.source == "a":
            return True
        asked.append(action)
        if len(asked) == 3:
            push(stand, 0.5)
        return None if len(asked) < 8 else True

    run = Coordinator(line(go), stand.robot, stand.model, observers=[note], permission=permission)
    assert stand.finish(run).outcome == "GiveUp"
    assert stand.backend.stops > stops[-1]


def test_pushed_back_to_where_an_action_had_ended(stand: Stand, go: type[Go]) -> None:
    """N9: a situation holds again that the run was in between two actions."""
    names = [Situation(name, facts) for name, facts in zip("abcd", (HOME, FAR, FAR, FAR), strict=True)]
    bound = Binding.of(go())
    ways = [Action(a, b, bound, 1.0, permit=a == "c") for a, b in ("ab", "bc", "cd")]
    asked = []
    events: list[Event] = []

    def permission(action: Action) -> bool | None:
        if action.source != "c":
            return True
        asked.append(action)
        if len(asked) == 3:
            push(stand, -1.0)
        return None if len(asked) < 8 else True

    network = ActionNetwork.build(names, ways, "a", "d")
    run = Coordinator(network, stand.robot, stand.model, observers=[events.append], permission=permission)
    assert stand.finish(run).outcome == "Success"
    assert [event.action.source for event in events if isinstance(event, Started)] == ["a", "b", "b", "c"]


@pytest.mark.parametrize(("sigma", "found"), [(0.05, "a"), (0.15, None)])
def test_an_unsure_pose_tells_no_situation(
    stand: Stand, go: type[Go], sigma: float, found: str | None
) -> None:
    """N9: three sigmas of the measurement have to stay within the tolerance."""
    here = take_snapshot(stand.robot, {})
    far = replace(here, pose=type(here.pose)(1.0, 0.0, 0.0))
    watch = WorldWatch(stand.robot, line(go), {"a": here, "b": far})
    now = replace(here, dead_reckoned=False, pose_sigma=(sigma, 0.001))
    assert watch.situation("b", far, now) == found


def test_a_pose_that_is_not_surely_known_has_not_moved(stand: Stand) -> None:
    """N9: a pose that is measured elsewhere has moved, whatever its uncertainty."""
    here = take_snapshot(stand.robot, {})
    unsure = replace(here, dead_reckoned=False, pose_sigma=(0.5, 0.3))
    assert not residuals(here, unsure, stand.robot.spec).moved
    far = replace(unsure, pose=type(here.pose)(0.5, 0.0, 0.0))
    assert dict(residuals(here, far, stand.robot.spec).moved) == {"base_mm": 500.0}


def test_who_found_more_changed_than_the_base_tells_no_situation(stand: Stand, go: type[Go]) -> None:
    """N9: base and fingers are where they once were, but no sensor shows whether more was changed
    meanwhile.
    """
    here = replace(take_snapshot(stand.robot, {}), gripper_width=0.05)
    far = replace(here, pose=type(here.pose)(1.0, 0.0, 0.0), gripper_width=0.0)
    watch = WorldWatch(stand.robot, line(go), {"a": here, "b": far})
    assert watch.situation("b", far, here) is None
    assert watch.situation("b", replace(far, gripper_width=0.05), here) == "a"


def test_a_precondition_that_breaks_counts_as_unmet(
    stand: Stand, go: type[Go], monkeypatch: pytest.MonkeyPatch
) -> None:
    """N7: an action whose precondition raises is not started."""
    asked = []
    events: list[Event] = []

    def broken(self: Go, robot: Robot, model: ModelView) -> str:
        asked.append(robot.time)
        if len(asked) == 1:
            raise ZeroDivisionError("oh")
        return ""

    monkeypatch.setattr(go, "unmet_precondition", broken)
    end = stand.finish(Coordinator(line(go), stand.robot, stand.model, observers=[events.append]))
    assert (end.outcome, end.fails) == ("Success", 1)
    assert [event.reason for event in events if isinstance(event, LeftOut)] == ["ZeroDivisionError: oh"]


class Short(ActionPrimitive):
    """Primitive that drives, then fails with a discrepancy."""

    drives_s: float
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        end = robot.time + self.drives_s
        while robot.time < end:
            robot.base.drive(0.2, 0.0)
            yield
        raise Discrepancy("nobody is there")


@pytest.mark.parametrize(("drives_s", "why"), [(9.0, "it took longer than 2 s"), (1.7, "nobody is there")])
def test_a_time_out_never_calls_back_from_restoring(stand: Stand, drives_s: float, why: str) -> None:
    """A4: the way back takes the time that it takes."""
    action = Action("a", "b", Binding.of(Short(drives_s=drives_s)), 1.0, attempts=1, time_out_s=2.0)
    network = ActionNetwork.build([Situation("a"), Situation("b")], [action], "a", "b")
    events: list[Event] = []
    stand.finish(Coordinator(network, stand.robot, stand.model, observers=[events.append]))
    (ended,) = [event.outcome for event in events if isinstance(event, Ended)]
    assert isinstance(ended, Fail)
    assert ended.reason == why
    assert stand.robot.time > 3.0


def test_what_else_may_have_changed_nobody_knows(stand: Stand, go: type[Go], tmp_path: Path) -> None:
    """N9: where the book is in other hands by then, being back at the start doesn't bring it back."""
    facts = (HOME, {"base": "far", "book": "on the shelf"}, {"base": "far", "book": "on the shelf"})
    end, _, _ = pushed_while_asked(stand, line(go, facts), -1.0, tmp_path)
    assert end.outcome == "GiveUp"


def test_a_fault_in_planning_stops_and_asks_for_a_person(
    stand: Stand, go: type[Go], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """N10: with its traceback in the journal."""

    def broken(planner: Planner, situation: str) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(Planner, "plan", broken)
    with Journal(tmp_path / "j") as journal:
        end = stand.finish(Coordinator(line(go), stand.robot, stand.model, journal))
    assert (end.outcome, end.reason) == ("GiveUp", "planning failed: ZeroDivisionError: oh")
    assert stand.backend.stops
    assert "in broken" in read_journal(tmp_path / "j").records[0]["error"]


def test_two_primitives_at_a_time_both_stop_and_give_up(stand: Stand, go: type[Go]) -> None:
    """N12"""
    ends: list[Any] = []
    running = [attempt(go(), stand.robot, stand.model) for _ in range(2)]
    for _ in range(200):
        for group in list(running):
            try:
                next(group)
            except StopIteration as end:
                ends.append(end.value)
                running.remove(group)
        stand.robot.step()
    assert [type(item) for item in ends] == [GiveUp, GiveUp]
    assert all(item.reason == NOT_ALONE for item in ends)
    assert stand.backend.wheels.command == (0.0, 0.0)
