"""Runs through networks (rows N1 to N6, N11)."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from handcart.backends.robot.robot import Robot
from handcart.networks.analysis.worst_cases import worst_cases
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Ended, Event, LeftOut, Planned, Started
from handcart.networks.graph.network import Action, ActionNetwork, Binding, NetworkError, Situation
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from tests.journals import timeless_records
from tests.networks.conftest import Stand


def coordinator(stand: Stand, network: ActionNetwork, **more: Any) -> Coordinator:
    return Coordinator(network, stand.robot, stand.model, **more)


def names(events: list[Event]) -> list[str]:
    begun: list[Any] = [event.primitive for event in events if isinstance(event, Started)]
    return [primitive.name for primitive in begun]


def test_two_ways_and_the_cheap_one_fails(stand: Stand) -> None:
    network = stand.network("a m cheap 10", "a z dear 30", "m z last 1")
    stand.script["cheap"] = deque("FF")
    events: list[Event] = []
    end = stand.finish(coordinator(stand, network, observers=[events.append]))
    # 10 + 1 and 20 + 1 are cheaper than 30, 40 + 1 isn't.
    assert names(events) == ["cheap", "cheap", "dear"]
    assert (end.outcome, end.actions, end.fails, end.replans) == ("Success", 3, 2, 2)
    assert end.exit_status == 0


def test_unreachable_from_the_start_ends_without_an_action(stand: Stand) -> None:
    """N1: exit status 3 with an explanation, and no motion."""
    network = stand.network("a b one 1", "c z two 1")
    end = stand.finish(coordinator(stand, network))
    assert (end.outcome, end.exit_status, end.actions, end.situation) == ("Fail", 3, 0, "a")
    assert end.reason == "no way left from a to z: nothing leads from a there"


def test_unreachable_after_fails_names_what_blocks(stand: Stand) -> None:
    """N2: exit status 3 in the last situation."""
    network = stand.network("a b one 1", "b z two 1 2", "b z other 5 1")
    stand.script |= {"two": deque("FFF"), "other": deque("P")}
    end = stand.finish(coordinator(stand, network))
    assert (end.outcome, end.situation, end.fails) == ("Fail", "b", 3)
    assert end.reason == (
        "no way left from b to z: THINK with name: two (b to z) failed 2 times, last: two failed; "
        "THINK with name: other (b to z) failed 1 time, last: other can't be"
    )


@pytest.mark.parametrize("cost", [0.0, -1.0, float("nan"), float("inf")])
def test_costs_that_are_none(stand: Stand, cost: float) -> None:
    """N3."""
    bound = Binding.of(stand.Think(name="x"))
    with pytest.raises(NetworkError, match="cost_s"):
        ActionNetwork.build([Situation("a"), Situation("z")], [Action("a", "z", bound, cost)], "a", "z")


def test_everything_wrong_with_a_network_at_once(stand: Stand) -> None:
    bound = Binding.of(stand.Think(name="x"))
    situations = [Situation("a", {"book": "here"}), Situation("b", {"book": "there"}), Situation("b")]
    with pytest.raises(NetworkError) as error:
        ActionNetwork.build(situations, [Action("a", "c", bound, 1.0, 0, "a")], "a", "zz")
    assert len(str(error.value).splitlines()) == 4


def test_fail_may_not_change_physical_facts(stand: Stand) -> None:
    bound = Binding.of(stand.Think(name="x"))
    situations = [Situation("a", {"book": "here"}), Situation("b", {"book": "there"})]
    with pytest.raises(NetworkError, match="other physical facts"):
        ActionNetwork.build(situations, [Action("a", "b", bound, on_fail="b")], "a", "b")


def test_cycles_and_self_loops_end(stand: Stand) -> None:
    """N4."""
    network = stand.network("a a loop 0.001", "a b there 1", "b a back 0.001", "b z on 1")
    assert stand.finish(coordinator(stand, network)).actions == 2


def test_fail_leads_to_the_situation_that_knows_more(stand: Stand) -> None:
    network = stand.network("a z drive 1 3 blocked", "blocked a modify 1", "blocked z around 9")
    stand.script["drive"] = deque("F")
    events: list[Event] = []
    end = stand.finish(coordinator(stand, network, observers=[events.append]))
    assert names(events) == ["drive", "modify", "drive"]
    assert end.outcome == "Success"


def test_give_up_stays(stand: Stand) -> None:
    network = stand.network("a z ask 1", "a z other 5")
    stand.script["ask"] = deque("G")
    end = stand.finish(coordinator(stand, network))
    assert (end.outcome, end.exit_status, end.situation) == ("GiveUp", 4, "a")
    assert "ask needs help" in end.reason


def test_value_not_known_counts_as_a_fail(stand: Stand) -> None:
    """N7: not started, counted."""
    late = Binding(stand.Think, {"name": "x"}, {"text": "book.shelf"})
    network = ActionNetwork.build(
        [Situation("a"), Situation("z")], [Action("a", "z", late, 1.0, 2)], "a", "z"
    )
    events: list[Event] = []
    end = stand.finish(coordinator(stand, network, observers=[events.append]))
    assert (end.outcome, end.actions, end.fails) == ("Fail", 0, 2)
    assert "book.shelf is not known yet" in end.reason
    assert sum(isinstance(event, LeftOut) for event in events) == 2


def test_refused_permission_counts_as_a_fail(stand: Stand) -> None:
    network = stand.network("a z one 1 1", "a z two 2 1")
    answers = iter([None, False, None, None, True])
    end = stand.finish(coordinator(stand, network, permission=lambda action: next(answers)))
    assert (end.outcome, end.actions, end.fails) == ("Success", 1, 1)


networks = st.lists(
    st.tuples(
        st.integers(0, 4), st.integers(0, 5), st.integers(1, 20), st.integers(1, 3), st.integers(-1, 4)
    ),
    min_size=1,
    max_size=10,
)


@pytest.mark.slow
@given(networks, st.lists(st.text("SSFFP", max_size=6), min_size=10, max_size=10))
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_every_run_ends_within_its_bound(
    new_stand: Callable[[], Stand], rows: Any, outcomes: list[str]
) -> None:
    """N4, N5, N6: whatever the network and whatever fails."""
    stand = new_stand()
    built = [
        f"{source} {target} p{number} {cost} {attempts}" + (f" {on_fail}" if on_fail >= 0 else "")
        for number, (source, target, cost, attempts, on_fail) in enumerate(rows)
    ]
    network = stand.network(*built, start="0", goal="5")
    stand.script |= {f"p{number}": deque(pattern) for number, pattern in enumerate(outcomes)}
    events: list[Event] = []
    end = stand.finish(coordinator(stand, network, observers=[events.append]))
    assert end.actions <= network.bound()
    assert end.actions <= worst_cases(network).longest  # what `handcart check` states
    assert end.fails <= sum(action.attempts for action in network.actions)
    assert end.outcome == ("Success" if end.situation == "5" else "Fail")
    failed = [
        event.action.index
        for event in events
        if isinstance(event, Ended) and type(event.outcome).__name__ == "Fail"
    ]
    assert all(failed.count(a.index) <= a.attempts for a in network.actions)


def test_same_run_same_journal(new_stand: Callable[[], Stand], tmp_path: Path) -> None:
    """N11: apart from the wall clock."""
    journals = []
    for number in range(2):
        stand = new_stand()
        network = stand.network("a b one 1", "a b two 1", "b z three 1", "b z four 2")
        stand.script |= {"one": deque("F"), "three": deque("FF")}
        path = tmp_path / f"{number}.jsonl"
        with Journal(path) as journal:
            stand.finish(coordinator(stand, network, journal=journal))
        journals.append(timeless_records(path))
    assert journals[0] == journals[1]
    kinds = [record["kind"] for record in journals[0]]
    assert kinds[:4] == ["PLAN", "START", "RESULT", "PLAN"]
    assert kinds[-1] == "END"


def test_an_element_left_undone_is_journaled_and_ends_in_fail(stand: Stand, tmp_path: Path) -> None:
    """Each by its element's name; where it has none, by the situation that it was left in."""
    situations = [Situation("a", element="book 1"), Situation("b"), Situation("z")]
    network = ActionNetwork.build(situations, [Action("a", "b", None), Action("b", "z", None)], "a", "z")
    events: list[Event] = []
    with Journal(tmp_path / "j") as journal:
        end = stand.finish(coordinator(stand, network, journal=journal, observers=[events.append]))
    assert (end.outcome, end.reason, end.skipped) == ("Fail", "left undone: book 1, b", ("book 1", "b"))
    assert (end.situation, end.actions, end.fails) == ("z", 0, 0)
    records = [record for record in read_journal(tmp_path / "j").records if record["kind"] == "SKIP"]
    assert [(record["action"], record["element"]) for record in records] == [(0, "book 1"), (1, "b")]
    left = [event.reason for event in events if isinstance(event, LeftOut)]
    assert left == ["book 1 is left undone", "b is left undone"]


def test_without_anybody_to_ask_what_needs_a_permit_does_not_start(stand: Stand) -> None:
    network = stand.network("a z one 1 1", "a z two 2 1")
    permitted = replace(network.actions[0], permit=True)
    network = ActionNetwork.build(network.situations.values(), [permitted, network.actions[1]], "a", "z")
    events: list[Event] = []
    end = stand.finish(coordinator(stand, network, observers=[events.append]))
    assert names(events) == ["two"]
    assert (end.outcome, end.fails) == ("Success", 1)
    assert [event.reason for event in events if isinstance(event, LeftOut)] == ["permission was refused"]


def test_nothing_waits_for_permission_after_a_stop(stand: Stand) -> None:
    run = coordinator(stand, stand.network("a z one 1"), permission=lambda action: None)
    end = stand.finish(run, {3: lambda: run.request(Request.STOP)})
    assert (end.outcome, run.asks) == ("Cancelled", None)


def test_what_waits_for_permission_is_told_only_while_it_waits(stand: Stand) -> None:
    run: Any = None
    asked: list[Any] = []
    answers = iter([None, None, True])

    def permission(action: Action) -> bool | None:
        asked.append(run.asks)
        return next(answers)

    network = stand.network("a z one 1")
    run = coordinator(stand, network, permission=permission)
    assert stand.finish(run).outcome == "Success"
    assert asked == [None, network.actions[0], network.actions[0]]
    assert run.asks is None


def test_a_fault_in_planning_stops_and_calls_a_person(
    stand: Stand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """N10"""

    def plan(_: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("handcart.networks.graph.route.RunDecisions.plan", plan)
    with Journal(tmp_path / "j") as journal:
        end = stand.finish(coordinator(stand, stand.network("a z one 1"), journal=journal))
    assert end.outcome == "GiveUp"
    assert end.reason == "planning failed: ZeroDivisionError: division by zero"
    assert stand.backend.stops == 1
    record = read_journal(tmp_path / "j").records[0]
    assert (record["kind"], record["situation"]) == ("PLAN", "a")
    assert "ZeroDivisionError" in record["error"]


@pytest.mark.parametrize(
    ("outcome", "reason", "stop"),
    [
        ("Error", "it broke; how action 1 ended is not in the journal for good", True),
        ("GiveUp", "it broke", True),
    ],
)
def test_a_run_that_is_broken_off_says_what_is_not_known(
    stand: Stand, tmp_path: Path, outcome: Any, reason: str, stop: bool
) -> None:
    with Journal(tmp_path / "j") as journal:
        run = coordinator(stand, stand.driving(), journal=journal)
        periods = run.run()
        for _ in range(15):
            next(periods)
            stand.robot.step()
        end = run.broken_off("it broke", outcome)
        *_, stopped, ended = read_journal(tmp_path / "j").records
    assert (end.outcome, end.reason, end.situation, end.actions) == (outcome, reason, "a", 1)
    assert (stopped["kind"], stopped["cause"]) == ("STOP", reason)
    assert (ended["kind"], ended["reason"]) == ("END", reason)
    assert ended["at"]["base"][0] == pytest.approx(stand.robot.pose.x)


def test_a_run_broken_off_between_actions_knows_how_the_last_ended(stand: Stand) -> None:
    run = coordinator(stand, stand.network("a z one 1"))
    stand.finish(run)
    assert run.broken_off("it broke").reason == "it broke"


def test_a_journal_that_broke_the_run_off_does_so_only_once(stand: Stand, tmp_path: Path) -> None:
    journal = Journal(tmp_path / "j")
    run = coordinator(stand, stand.driving(), journal=journal)
    next(run.run())
    journal.close()
    assert run.broken_off("the disk is gone").outcome == "Error"


def test_plan_is_kept_while_nothing_fails(stand: Stand) -> None:
    network = stand.network("a b one 1", "b c two 1", "c z three 1")
    events: list[Event] = []
    stand.finish(coordinator(stand, network, observers=[events.append]))
    assert sum(isinstance(event, Planned) for event in events) == 1


class Notice(ActionPrimitive):
    """Senses one thing more; fails where its script says so."""

    name: str
    only_knowledge: ClassVar = True
    writes: ClassVar = ("obstacles",)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        model.obstacles = np.vstack([model.obstacles, [[1.0, 2.0]]])
        if self.name == "fails":
            raise Discrepancy("it is in the way")
        return
        yield


def test_what_an_action_learned_stands_in_its_result(stand: Stand, tmp_path: Path) -> None:
    """Also what a Fail left known; and nothing where nothing changed."""
    bound = [Binding.of(Notice(name=name)) for name in ("fails", "works")] + [Binding.of(stand.Drive())]
    actions = [
        Action("a", "b", bound[0], 1.0, 1),
        Action("a", "b", bound[1], 5.0),
        Action("b", "c", bound[2], 1.0),
    ]
    network = ActionNetwork.build(map(Situation, "abc"), actions, "a", "c")
    with Journal(tmp_path / "j") as journal:
        stand.finish(coordinator(stand, network, journal=journal))
    results = [record for record in read_journal(tmp_path / "j").records if record["kind"] == "RESULT"]
    assert [result.get("learned") for result in results] == [{"obstacles": 1}, {"obstacles": 2}, None]
