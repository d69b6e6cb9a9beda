"""An action asks for permission as its entry says, or else as its primitive does."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.networks.task.task_file import load_task

TASK = Path(__file__).parents[3] / "tasks" / "fetch_and_carry" / "hand_over.yaml"


@pytest.mark.parametrize(
    ("key", "expected"), [("", True), ("permit: operator, ", True), ("permit: none, ", False)]
)
def test_hand_over_asks_unless_its_entry_says_otherwise(tmp_path: Path, key: str, expected: bool) -> None:
    for name in ("map.yaml", "map.png", "places.yaml", "objects.yaml", "person.yaml"):
        (tmp_path / name).write_bytes(TASK.with_name(name).read_bytes())
    text = TASK.read_text(encoding="utf-8").replace("do: HAND_OVER, ", f"do: HAND_OVER, {key}")
    (tmp_path / "task.yaml").write_text(text, encoding="utf-8")
    actions = load_task(tmp_path / "task.yaml").network.actions
    assert {action.do: action.permit for action in actions} == {
        **dict.fromkeys((action.do for action in actions), False),
        "HAND_OVER": expected,
    }
