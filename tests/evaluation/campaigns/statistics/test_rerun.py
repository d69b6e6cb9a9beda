"""The command that repeats one trial of a campaign."""

from __future__ import annotations

import pytest

from handcart.evaluation.campaigns.statistics.rerun import rerun

SAID = {"task": "t.yaml", "generate": [], "settings": {}, "first": 0, "trials": 20}


@pytest.mark.parametrize(
    ("said", "command"),
    [
        ({}, "handcart run t.yaml --seed 7"),
        ({"settings": {"tour": "[a, b]"}}, "handcart run t.yaml --seed 7 --set 'tour=[a, b]'"),
        (
            {"generate": ["room.gap=false", "room.size=2"]},
            "handcart campaign t.yaml --trials 1 --first 7 --generate room.gap=false --generate room.size=2",
        ),
        ({"faults": "f.yaml"}, "handcart campaign t.yaml --trials 1 --first 7 --faults f.yaml"),
        ({"level": "network"}, "handcart campaign t.yaml --trials 1 --first 7 --level network"),
        (
            {"vary_file": "v.yaml"},
            "handcart campaign t.yaml --first 0 --trials 20 --vary v.yaml --shard 8/20 --out again-7",
        ),
        ({"backend": "mujoco"}, "handcart run t.yaml --seed 7 --backend mujoco"),
    ],
)
def test_trial_is_repeated_by_its_campaigns_arguments(said: dict[str, object], command: str) -> None:
    assert rerun(SAID | said, 7) == command
