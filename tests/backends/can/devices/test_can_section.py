"""Errors in the section `can` of a robot's file, with their places."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from handcart.backends.description.can_spec import JointDriveSpec
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from handcart.networks.task.preparing import check, prepare

ROOT = Path(__file__).resolve().parents[4]

JOINT_6 = "    - {node: 16, counts_per_rev: 65536, gear_ratio: 50, rated_torque_nm: 30}\n"


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (JOINT_6, "", "5 drives for 6 joints; allowed: one for each"),
        ("{node: 16,", "{node: 16, stop: brake_then_disable,", "would fall with stop: brake_then_disable"),
        ("{node: 21,", "{node: 16,", ":56:19: joint 6 and gripper have the node 16; allowed: each its own"),
        ("{node: 16,", "{node: 16, lead_mm: 5,", "lead_mm of a joint that turns; allowed: rated_torque_nm"),
        (", rated_torque_nm: 120}", "}", "'rated_torque_nm' is missing; needed: it, for a joint that turns"),
        ("{node: 21,", "{node: 127,", "our_node and gripper have the node 127"),
        ("channel: can0", "channel: can0\n  heartbeat_timeout_ms: 60", "from twice heartbeat_ms, 100"),
        (
            "channel: can0",
            "channel: can0\n  heartbeat_ms: 20\n  heartbeat_timeout_ms: 60",
            "60 ms, and our heartbeat is sent once in a period of 50 ms; allowed: from twice that",
        ),
        ("period_s: 0.05", "period_s: 0.0501", "allowed: whole milliseconds up to 255"),
        ("{node: 21,", "{node: 21, eds: gone.eds,", "missing file 'gone.eds'"),
        ("{node: 21,", "{node: 21, mode: csp,", "profile"),
        ("interface: socketcan", "interface: sockatcan", "unknown interface 'sockatcan'; did you mean"),
    ],
)
def test_it_is_told_with_line_and_column(tmp_path: Path, before: str, after: str, message: str) -> None:
    text = (SHIPPED_FOLDER / "librarian" / "robot.yaml").read_text(encoding="utf-8")
    assert before in text
    if before.startswith("period_s"):
        text = text.replace("{node: 1,", "{node: 1, mode: csv,")
    path = tmp_path / "robot.yaml"
    path.write_text(text.replace(before, after), encoding="utf-8")
    (tmp_path / "librarian.urdf").write_bytes((SHIPPED_FOLDER / "librarian" / "librarian.urdf").read_bytes())
    with pytest.raises(FileError) as error:
        load_robot(str(path))
    assert message in str(error.value)
    assert f"{path}:" in str(error.value)


def test_a_sliding_joint_is_told_in_mm() -> None:
    """A lift: 40 turns of its motor for one of a spindle that takes it 5 mm on."""
    lift = JointDriveSpec(node=3, counts_per_rev=1000, gear_ratio=40, lead_mm=5.0, rated_force_n=900.0)
    assert lift.counts_per_unit == pytest.approx(1000 * 40 / 0.005)
    assert lift.following == pytest.approx(0.005)
    assert lift.rated_effort == 900.0
    turning = JointDriveSpec(node=3, counts_per_rev=1000, gear_ratio=40, rated_torque_nm=30.0)
    assert turning.counts_per_unit == pytest.approx(1000 * 40 / (2 * math.pi))
    assert turning.following == pytest.approx(math.radians(3.0))
    assert turning.rated_effort == 30.0


def test_a_brake_lets_an_axis_under_gravity_be_disabled(tmp_path: Path) -> None:
    text = (SHIPPED_FOLDER / "librarian" / "robot.yaml").read_text(encoding="utf-8")
    path = tmp_path / "robot.yaml"
    path.write_text(
        text.replace("{node: 16,", "{node: 16, stop: brake_then_disable, brake: true,"), encoding="utf-8"
    )
    (tmp_path / "librarian.urdf").write_bytes((SHIPPED_FOLDER / "librarian" / "librarian.urdf").read_bytes())
    spec = load_robot(str(path)).can
    assert spec is not None
    assert spec.joints[5].brake


def test_only_who_drives_by_can_or_looks_is_told_all_of_it(tmp_path: Path) -> None:
    """A drive in simulation asks nothing of the bus."""
    text = (SHIPPED_FOLDER / "librarian" / "robot.yaml").read_text(encoding="utf-8")
    path = tmp_path / "robot.yaml"
    path.write_text(text.replace("{node: 21,", "{node: 16,"), encoding="utf-8")
    (tmp_path / "librarian.urdf").write_bytes((SHIPPED_FOLDER / "librarian" / "librarian.urdf").read_bytes())
    task, settings = ROOT / "tasks" / "drive_map" / "task.yaml", {"robot": str(path)}
    with prepare(task, "kinematic", settings) as prepared:
        assert prepared.robot.spec.can is not None
    with pytest.raises(FileError, match="joint 6 and gripper have the node 16"):
        prepare(task, "can", settings, bench="kinematic")
    with pytest.raises(FileError, match="joint 6 and gripper have the node 16"):
        check(task, "kinematic", settings)
