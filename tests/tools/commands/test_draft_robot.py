"""`handcart robot --from-ros`, before a bench in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from handcart.backends.loading.robot_loading import load_robot
from tests.tools.conftest import Said


def test_a_draft_from_the_air_is_a_robot(handcart: Callable[..., Said], tmp_path: Path) -> None:
    file = tmp_path / "new" / "robot.yaml"
    words = ("robot", str(file), "--from-ros", "--bench", "cart", "--seconds", "0.5")
    said = handcart(*words)
    assert said.status == 0, said.err
    robot = load_robot(str(file))
    assert robot.ros2 is not None
    assert robot.ros2.odometry.frame == "odom"
    assert robot.ros2.velocity.topic == "cmd_vel"
    assert robot.range_sensor is not None
    assert (robot.range_sensor.beams, robot.range_sensor.reach_m) == (360, 12.0)
    assert file.read_text(encoding="utf-8").startswith("# Made by `handcart robot` from the robot's topics;")
    again = handcart(*words)
    assert again.status == 2
    assert "is there already" in again.err


def test_a_place_for_the_draft_is_refused_before_it_listens(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    for file, words in (
        (tmp_path / "taken" / "robot.yaml", "is not a folder"),
        (tmp_path / "r.urdf", "*.yaml"),
    ):
        said = handcart("robot", str(file), "--from-ros", "--seconds", "600")
        assert said.status == 2
        assert words in said.err
    assert [item.name for item in tmp_path.iterdir()] == ["taken"]
