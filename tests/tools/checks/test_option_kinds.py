"""Options of `handcart check` with files that they do not concern."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize(
    ("file", "words", "message"),
    [
        (
            "drive_map",
            ("--picture", "p.svg"),
            "is a task, but --picture is for a robot's file; allowed: --set, --policy",
        ),
        ("drive_map", ("--allow",), "is a task, but --allow is for a robot's file"),
        ("drive_map", ("--backend", "mujoco"), "is a task, but --backend is for a robot's file"),
        ("drive_map", ("--draft", "robot.yaml"), "is a task, but --draft is for a URDF"),
        ("cart", ("--set", "a=1"), "is a robot's file, but --set is for a task; allowed: --picture"),
        ("cart", ("--policy", "rule"), "is a robot's file, but --policy is for a task"),
        (ROOT / "tasks/return_book/world.yaml", ("--allow",), "is a world, but --allow"),
        (ROOT / "tasks/drive_map/map.yaml", ("--allow",), "is a map, but --allow"),
        (
            "r.urdf",
            ("--picture", "p.svg"),
            "is a URDF, but --picture is for a robot's file; allowed: --draft",
        ),
        (
            "cart",
            ("--ros2", "--picture", "p.svg"),
            "--picture with --ros2; allowed: --bench, --bag, --seconds",
        ),
    ],
)
def test_options_for_other_kinds_of_files_are_refused(
    handcart: Callable[..., Said], tmp_path: Path, file: str | Path, words: tuple[str, ...], message: str
) -> None:
    if file == "r.urdf":
        file = tmp_path / "r.urdf"
        file.write_text("<robot name='r'><link name='base'/></robot>")
    said = handcart("check", file, *words)
    assert said.status == 2
    assert message in said.err
    said = handcart("check", file, *words, "--json")
    assert message in json.loads(said.out)["findings"][0]["message"]
