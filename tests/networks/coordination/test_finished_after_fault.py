"""Actions that a fault breaks off after a point of no return, and that are completed while withdrawing."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from handcart.backends.backend import CommandError
from handcart.backends.robot.robot import Robot
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.networks.journal.journal import Journal
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.journal.retracing import standing
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.patience import Patience
from tests.networks.conftest import Drive, Stand


class Lay(Drive):
    """Meets a fault, or finds something wrong, after its point of no return; withdraws after some tries."""

    finds: bool = False
    is_measured: bool = True
    breaks: int = 0
    tries: ClassVar[list[str]] = []

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield from super().motion(robot, model)
        self.point_of_no_return("it is laid")
        yield
        if self.finds:
            raise Discrepancy("it fell over")
        raise CommandError("refused")

    def finish(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        self.tries.append("finish")
        yield
        if len(self.tries) <= self.breaks:
            raise CommandError("refused again")
        return self.is_measured


def network_of(lay: Lay, tries: int = 1) -> ActionNetwork:
    """Return a network with two such actions, one after the other."""
    Lay.tries.clear()
    actions = [Action("a", "b", Binding.of(lay), 1.0), Action("b", "z", Binding.of(lay), 1.0)]
    network = ActionNetwork.build(map(Situation, "abz"), actions, "a", "z")
    return replace(network, restoring=Patience(tries, 0.1))


def test_a_measured_effect_lets_the_run_go_on(stand: Stand, tmp_path: Path) -> None:
    network = network_of(Lay(periods=2))
    with Journal(tmp_path / "j") as journal:
        journal.append("RUN", 0.0, {"schema": "x", "network": network.fingerprint()})
        end = stand.finish(Coordinator(network, stand.robot, stand.model, journal))
    assert (end.outcome, end.actions, end.fails) == ("Success", 2, 0)
    records = read_journal(tmp_path / "j").records
    results = [record for record in records if record["kind"] == "RESULT"]
    assert [result["evidence"]["finished_after"] for result in results] == ["CommandError: refused"] * 2
    assert standing(network, records).route.situation == "z"


@pytest.mark.parametrize(
    ("lay", "tries", "outcome"),
    [
        (Lay(periods=2, is_measured=False), 3, "GiveUp"),
        (Lay(periods=2, finds=True), 3, "GiveUp"),
        (Lay(periods=2, breaks=1), 1, "GiveUp"),
        (Lay(periods=2, breaks=1), 2, "Success"),
        (Lay(periods=2, breaks=2), 2, "GiveUp"),
    ],
)
def test_otherwise_a_person_has_to_look(stand: Stand, lay: Lay, tries: int, outcome: str) -> None:
    """What a primitive found wrong itself is no fault; withdrawing is tried as often as restoring."""
    end = stand.finish(Coordinator(network_of(lay, tries), stand.robot, stand.model))
    assert end.outcome == outcome
    if outcome == "GiveUp":
        assert "after a point of no return (it is laid)" in end.reason
