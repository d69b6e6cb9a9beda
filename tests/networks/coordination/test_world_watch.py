"""Continuation of a run after the robot was lifted between two actions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.networks.coordination.world_watch import WorldWatch
from handcart.networks.task.task_file import load_task

DRIVE_MAP = Path(__file__).parents[3] / "tasks" / "drive_map"
NO_ROBOT: Any = None


@pytest.mark.parametrize(
    ("file", "settings", "here", "there"),
    [
        ("locate.yaml", {}, "located", "lost"),
        ("task.yaml", {"start": "unknown", "tour": "[desk]"}, "toured", "pose unknown"),
        ("task.yaml", {"tour": "[desk]"}, "toured", None),
    ],
)
def test_a_lifted_robot_goes_on_where_locate_starts(
    file: str, settings: dict[str, str], here: str, there: str | None
) -> None:
    network = load_task(DRIVE_MAP / file, settings).network
    assert WorldWatch(NO_ROBOT, network, {}).unlocated_situation(here) == there
