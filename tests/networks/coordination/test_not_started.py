"""Situations that a run is in after an action that could not be started."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest

from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
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
