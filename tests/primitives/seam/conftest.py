"""A robot at the shipped seam."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.seam_file import load_seam
from handcart.robotics.geometry.pose2 import Pose2

TASK = Path(__file__).parents[3] / "tasks" / "track_seam"


@pytest.fixture
def rig_at(tmp_path: Path) -> Callable[..., Rig]:
    """Return a maker of rigs at a place, with the first points of the seam known.

    `world` is added to the world, `new` replaces `old` in the robot's file.
    """

    def made(here: Pose2, last: int, world: str = "", old: str = "", new: str = "") -> Rig:
        place = f"x_m: {here.x}, y_m: {here.y}, heading_deg: {math.degrees(here.theta)}"
        for name, before, after in (
            ("world.yaml", "start: {x_m: 1.2, y_m: 1.2, heading_deg: 0.0}", f"start: {{{place}}}"),
            ("places.yaml", "  home: {", f"  here: {{{place}}}\n  home: {{"),
        ):
            text = (TASK / name).read_text(encoding="utf-8")
            assert text.count(before) == 1
            (tmp_path / name).write_text(text.replace(before, after), encoding="utf-8")
        with (tmp_path / "world.yaml").open("a", encoding="utf-8") as file:
            file.write(world)
        robot = (SHIPPED_FOLDER / "atrv" / "robot.yaml").read_text(encoding="utf-8")
        assert old in robot
        (tmp_path / "robot.yaml").write_text(robot.replace(old, new), encoding="utf-8")
        (tmp_path / "atrv.urdf").write_bytes((SHIPPED_FOLDER / "atrv" / "atrv.urdf").read_bytes())
        files = RigFiles(tmp_path / "world.yaml", TASK / "map.yaml", tmp_path / "places.yaml", {}, "here")
        rig = build_rig(files, robot=str(tmp_path / "robot.yaml"))
        rig.model.of(Seam).seam = load_seam(TASK / "seam.csv").part(0, last)
        return rig

    return made
