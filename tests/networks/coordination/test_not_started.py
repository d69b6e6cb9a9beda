"""Situations that a run is in after an action that could not be started."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import pytest

from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.run_end import RunEnd
from handcart.networks.graph.endings import FailEnding
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from tests.networks.conftest import Stand


class NeverReady(ActionPrimitive):
    """Primitive whose precondition is never met."""

    only_knowledge: ClassVar = True

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        return "the lamp is off"

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


@pytest.mark.parametrize("cause", ["precondition", "not_known"])
def test_causes_of_actions_not_started_decide_the_situation(stand: Stand, tmp_path: Path, cause: str) -> None:
    """A Fail of that cause leads to b, one of any other cause to c, from where nothing leads on."""
    unknown = Binding(stand.Think, {"name": "x"}, {"text": "book.shelf"})
    bound = Binding.of(NeverReady()) if cause == "precondition" else unknown
    endings = (FailEnding(cause, "b"),)
    actions = [
        Action("a", "z", bound, 1.0, 1, on_fail="c", fail_endings=endings),
        Action("b", "z", Binding.of(stand.Think(name="other")), 1.0),
    ]
    network = ActionNetwork.build(map(Situation, "abcz"), actions, "a", "z")
    with Journal(tmp_path / "j") as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        end = stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    assert (end.outcome, end.situation, end.fails) == ("Success", "z", 1)
    records = read_journal(tmp_path / "j").records
    refused = next(number for number, record in enumerate(records) if record["kind"] == "NOT_STARTED")
    assert records[refused]["cause"] == cause
    assert standing(network, records[: refused + 1]).route.situation == "b"


def journaled(
    stand: Stand, network: ActionNetwork, path: Path, **options: Any
) -> tuple[RunEnd, list[dict[str, Any]], int]:
    """Return a run's end, its records, and the number of the record in which its first action ended."""
    with Journal(path) as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        at = options.pop("at", {})
        run = Coordinator(network, stand.robot, stand.model, journal, **options)
        end = stand.finish(run, {period: partial(run.request, what) for period, what in at.items()})
    records = list(read_journal(path).records)
    ends = (number for number, record in enumerate(records) if record["kind"] in ("NOT_STARTED", "RESULT"))
    return end, records, next(ends)


def test_a_refused_action_leaves_the_situation_as_it_is(stand: Stand, tmp_path: Path) -> None:
    """A Fail of it would show that the way is blocked, from where nothing leads on."""
    network = stand.network("a z one 1 1 blocked", "a z two 9")
    end, records, number = journaled(
        stand, network, tmp_path / "j", permission=lambda action: action.index != 0
    )
    assert (end.outcome, end.situation, end.actions, end.fails) == ("Success", "z", 1, 1)
    assert records[number]["cause"] == "refused"
    position = standing(network, records[: number + 1])
    assert (position.route.situation, position.fails, position.cause) == ("a", 1, "refused")
    assert position.route.planner.is_out(network.actions[0])


def test_the_cause_of_an_early_restore_decides_the_situation(stand: Stand, tmp_path: Path) -> None:
    """The request comes while the robot still waits for rest before its start."""
    actions = [
        Action("a", "z", Binding.of(stand.Drive()), 1.0, 1, fail_endings=(FailEnding("cancelled", "b"),)),
        Action("b", "z", Binding.of(stand.Think(name="other")), 1.0),
    ]
    network = ActionNetwork.build(map(Situation, "abz"), actions, "a", "z")
    end, records, number = journaled(stand, network, tmp_path / "j", at={1: Request.RESTORE})
    assert (end.outcome, end.fails) == ("Success", 1)
    assert records[number]["cause"][0]["kind"] == "cancelled"
    assert standing(network, records[: number + 1]).route.situation == "b"


def test_an_early_preemption_counts_nothing_also_in_its_journal(stand: Stand, tmp_path: Path) -> None:
    network = stand.driving()
    end, records, number = journaled(stand, network, tmp_path / "j", at={1: Request.PREEMPT})
    assert (end.outcome, end.fails, end.actions) == ("Success", 0, 2)
    position = standing(network, records[: number + 1])
    assert (position.fails, position.route.planner.fails(network.actions[0])) == (0, 0)
