"""A run that is only imagined ends as the coordinator's would."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.networks.coordination.script import follow
from tests.networks.conftest import Stand

ROWS = ("a z near 1", "a z far 5 1")


@pytest.mark.parametrize(
    ("outcomes", "did", "ended", "cost_s"),
    [
        ([], ["near Success"], "Success", 1.0),
        (["Fail"], ["near Fail", "near Success"], "Success", 2.0),
        (["Fail", "Fail", "Fail"], ["near Fail"] * 3 + ["far Success"], "Success", 8.0),
        (["FailForGood"], ["near FailForGood", "far Success"], "Success", 6.0),
        (["FailForGood", "Fail"], ["near FailForGood", "far Fail"], "Fail", 6.0),
        (["Fail", "GiveUp", "Success"], ["near Fail", "near GiveUp"], "GiveUp", 2.0),
    ],
)
def test_outcomes_lead_where_they_would_lead_a_robot(
    stand: Stand, outcomes: Any, did: list[str], ended: str, cost_s: float
) -> None:
    network = stand.network(*ROWS)
    cost = {action.cost_s: str(action.binding.fixed["name"]) for action in network.actions if action.binding}
    imagined = follow(network, outcomes)
    lines = [line.rpartition(": ")[2].split(", ") for line in imagined.lines]
    assert [f"{cost[float(item.split()[0])]} {word}" for word, item in lines] == did
    assert (imagined.outcome, imagined.cost_s) == (ended, cost_s)
    assert imagined.situation == ("z" if ended == "Success" else "a")
    assert bool(imagined.reason) == (ended != "Success")
