"""Blocks that robot or camera cannot handle are refused before anything moves, and unseen ones explained."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.networks.task.preparing import check
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.outcomes.outcome import Fail

from .stacking import TASK, at_the_wall


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ("55, 60, 28", "building.yaml:3:11: the blocks are 55 mm long.*allowed: less than 50 mm"),
        ("12, 60, 28", "building.yaml:3:11: the blocks' upper sides are 12 x 60 mm.*allowed: at least 15 mm"),
    ],
)
def test_block_of_impossible_size_is_refused_with_its_line(tmp_path: Path, size: str, words: str) -> None:
    for path in TASK.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    plan = tmp_path / "building.yaml"
    plan.write_text(plan.read_text(encoding="utf-8").replace("25, 80, 40", size), encoding="utf-8")
    with pytest.raises(FileError, match=words):
        check(tmp_path / "task.yaml")


def test_unseen_block_is_explained_by_the_face_that_is_there(tmp_path: Path) -> None:
    world = (TASK / "unload_world.yaml").read_text(encoding="utf-8")
    seat = '{name: "2", on: robot, x_m: -0.31, y_m: 0.0, height_m: 0.45'
    assert seat in world
    (tmp_path / "world.yaml").write_text(world.replace(seat, seat + ", size_mm: [25, 50, 40]"), "utf-8")
    with at_the_wall(tmp_path / "world.yaml") as rig:
        rig.do(Fixate(landmark="stacking"))
        outcome = rig.do(PickUpBlock(number=2, at="robot", look=True))
    assert isinstance(outcome, Fail)
    assert "the nearest bright face is 5" in outcome.reason
    assert "needed: 80 x 25 mm" in outcome.reason
