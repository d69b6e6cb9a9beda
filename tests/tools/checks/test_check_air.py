"""`handcart check ROBOT --ros2`, before topics in this process."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from handcart.backends.description.robot_names import robot_path
from tests.tools.conftest import Said


def test_topics_of_a_bench_fit_the_cart(handcart: Callable[..., Said]) -> None:
    said = handcart("check", "cart", "--ros2", "--bench", "kinematic", "--seconds", "0.5")
    assert said.status == 0
    assert "cart: no fault found" in said.out
    assert "nav_msgs/Odometry" in said.out
    assert "20.0 Hz" in said.out


def test_a_difference_is_told_with_its_place(handcart: Callable[..., Said], tmp_path: Path) -> None:
    folder = tmp_path / "cart"
    shutil.copytree(robot_path("cart").parent, folder)
    file = folder / "robot.yaml"
    text = file.read_text(encoding="utf-8")
    section = "ros2: {odometry: {topic: odom, frame: map}, first_message_s: 0.5}"
    file.write_text(text.replace("ros2: {}", section), encoding="utf-8")
    line = next(n for n, item in enumerate(text.splitlines(), 1) if item.startswith("ros2"))
    words = ("check", str(file), "--ros2", "--bench", "kinematic", "--seconds", "0.5")
    said = handcart(*words)
    assert said.status == 2
    assert said.err.startswith(f"{file}:{line}:18: the odometry (odom): ")
    assert "its frame is 'odom'; allowed: 'map'" in said.err
    found = json.loads(handcart(*words, "--json").out)
    assert not found["ok"]
    assert found["findings"][0]["line"] == line
    assert found["robot"]["topics"][0]["topic"] == "odom"


def test_a_bag_without_ros2_is_not_passed_over(handcart: Callable[..., Said]) -> None:
    said = handcart("check", "cart", "--bag", "drive.mcap")
    assert said.status == 2
    assert "--bag without --ros2; needed: both" in said.err


def test_a_robot_without_topics_is_refused(handcart: Callable[..., Said], tmp_path: Path) -> None:
    folder = tmp_path / "cart"
    shutil.copytree(robot_path("cart").parent, folder)
    file = folder / "robot.yaml"
    file.write_text(file.read_text(encoding="utf-8").replace("ros2: {}", ""), encoding="utf-8")
    said = handcart("check", str(file), "--ros2", "--bench", "kinematic")
    assert said.status == 2
    assert f"the robot's file in {folder} has no section 'ros2'" in said.err
