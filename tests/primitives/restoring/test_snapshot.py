"""Tests of the residuals of a robot against an earlier state, by name and unit, and of their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import FrozenInstanceError, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.joint_units import JointUnits
from handcart.primitives.outcomes.residual import ResidualKind
from handcart.primitives.restoring.snapshot import (
    JOINT_NOISE,
    MIN_HELD_WIDTH_M,
    REST_PERIODS,
    REST_TIMEOUT_S,
    Snapshot,
    is_holding,
    residuals,
    settle,
    take_snapshot,
    take_snapshot_since_start,
)
from handcart.primitives.restoring.trace import Moment, Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief

TOLERANCE = SimpleNamespace(
    base_mm=40.0, base_deg=2.0, joints_deg=0.5, slides_mm=3.0, gripper_mm=1.0, object_mm=8.0
)
START = Snapshot(
    pose=Pose2(1.0, 2.0, 0.5),
    pose_sigma=(0.003, 0.001),
    joints=np.array([0.1, -0.2, 0.3]),
    joint_command=np.array([0.1, -0.2, 0.3]),
    gripper_command=0.05,
    gripper_width=0.04,
    holding=True,
    seen={"cup": (1.0, 0.0, 0.5), "pen": (0.0, 0.0, 0.0)},
)


def make_spec(slides: Sequence[bool] = (False,) * 3, endless: Sequence[bool] = (False,) * 3) -> Any:
    units = JointUnits(("a", "b", "c"), tuple(slides), tuple(endless))
    return SimpleNamespace(tolerance=TOLERANCE, joint_units=units)


SPEC = make_spec()


class Fingers:
    """A gripper that reads as the test says."""

    def __init__(self, width: float, presses: bool) -> None:
        self._width, self._presses = width, presses

    def width(self) -> float:
        return self._width

    def command(self) -> float:
        return self._width / 2

    def closed_on_something(self) -> bool:
        return self._presses


class Robot:
    """Robot at rest, with the parts that the test gives."""

    def __init__(self, arm: Any = None, gripper: Any = None, jumps: bool = False) -> None:
        parts = {Arm: arm, Gripper: gripper}
        self.backend = SimpleNamespace(get=parts.__getitem__)
        self.spec = SPEC
        self.pose, self.time = Pose2(1.0, 2.0, 0.5), 0.0
        self.base = SimpleNamespace(wheel_travel=lambda: (0.0, 0.0))
        self.localization = SimpleNamespace(
            sigma=(0.003, 0.001),
            dead_reckoned=True,
            odometry_pose=Pose2(7.0, 8.0, 9.0),
            POSE_JUMPS=jumps,
            displacement=Belief(np.array([0.003, 0.004, -0.01]), np.diag([4e-6, 9e-6, 1e-6])),
            displacements=0,
            stale_s=0.0,
            look_again=lambda: None,
        )


def arm_at(joints: list[float], command: list[float]) -> Any:
    return SimpleNamespace(joints=lambda: np.array(joints), command=lambda: np.array(command))


def test_nothing_has_moved_but_what_is_unsure() -> None:
    """3 sigma of both measurements."""
    assert residuals(START, START, SPEC) == {
        "base_mm": 0.0,
        "base_deg": 0.0,
        "base_unsure_mm": pytest.approx(3e3 * math.hypot(0.003, 0.003)),
        "base_unsure_deg": pytest.approx(math.degrees(3 * math.hypot(0.001, 0.001))),
        "gripper_mm": 0.0,
        "held": 0.0,
        "joints_deg": 0.0,
        "object cup mm": 0.0,
        "object pen mm": 0.0,
    }


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"pose": Pose2(1.03, 2.04, 0.5)}, {"base_mm": 50.0}),
        ({"pose": Pose2(1.0, 2.0, 0.4)}, {"base_deg": math.degrees(0.1)}),
        ({"pose": Pose2(1.0, 2.0, 0.5 + 2 * math.pi)}, {}),
        ({"gripper_width": 0.035}, {"gripper_mm": 5.0}),
        ({"gripper_width": 0.045}, {"gripper_mm": 5.0}),
        ({"holding": False}, {"held": math.inf}),
        ({"joints": np.array([0.1, -0.25, 0.32])}, {"joints_deg": math.degrees(0.05)}),
        ({"seen": {"cup": (1.0, 0.003, 0.504), "pen": (0.0, 0.0, 0.0)}}, {"object cup mm": 5.0}),
        ({"seen": {"cup": (1.0, 0.0, 0.5)}}, {"object pen mm": math.inf}),
        ({"joint_command": np.array([9.0, 9.0, 9.0]), "gripper_command": 9.0}, {}),
    ],
)
def test_each_residual_is_one_thing_in_its_unit(change: dict[str, Any], found: dict[str, float]) -> None:
    before, now = residuals(START, START, SPEC), residuals(START, replace(START, **change), SPEC)
    differs = {name: size for name, size in now.items() if size != pytest.approx(before[name], abs=1e-9)}
    assert differs == {name: pytest.approx(size) for name, size in found.items()}


def test_sliding_joints_are_in_mm_and_continuous_ones_within_a_turn() -> None:
    turned = replace(START, joints=START.joints + np.array([0.004, 2 * math.pi + 0.02, -0.01]))
    found = residuals(START, turned, make_spec((True, False, False), (False, True, False)))
    assert found["slides_mm"] == pytest.approx(4.0)
    assert found["joints_deg"] == pytest.approx(math.degrees(0.02))
    assert residuals(START, turned, make_spec((True,) * 3)).keys() & {"slides_mm", "joints_deg"} == {
        "slides_mm"
    }
    assert residuals(START, turned, make_spec())["joints_deg"] == pytest.approx(360.0 + math.degrees(0.02))
    back = replace(START, joints=START.joints - np.array([0.0, 2 * math.pi + 0.02, 0.0]))
    assert residuals(START, back, make_spec(endless=(False, True, False)))["joints_deg"] == pytest.approx(
        math.degrees(0.02)
    )


def test_a_pose_that_jumps_counts_as_far_as_it_was_felt() -> None:
    stood = replace(START, odometry_pose=Pose2(0.0, 0.0, 0.0), pose_sigma=(0.03, 0.02))
    jumped = replace(stood, pose=Pose2(1.5, 2.0, 1.0), odometry_pose=Pose2(0.006, 0.008, 0.01))
    sure = 3 * math.hypot(0.03, 0.03), 3 * math.hypot(0.02, 0.02)
    found = residuals(stood, jumped, SPEC)
    assert found["base_mm"] == pytest.approx(1e3 * (0.5 - sure[0]))
    assert found["base_deg"] == pytest.approx(math.degrees(0.5 - sure[1]))
    felt = residuals(stood, replace(jumped, pose=Pose2(1.1, 2.0, 0.52)), SPEC)
    assert (felt["base_mm"], felt["base_deg"]) == pytest.approx((10.0, math.degrees(0.01)))
    for unknown in (replace(stood, odometry_pose=None), stood):
        now = jumped if unknown is not stood else replace(jumped, odometry_pose=None)
        assert residuals(unknown, now, SPEC)["base_mm"] == pytest.approx(500.0)


def test_a_displacement_that_is_known_goes_before_the_poses() -> None:
    """Along its worst direction; unless where the robot is isn't known at all."""
    far = Belief(np.array([0.03, -0.04, -0.2]), np.diag([0.01, 0.02, 0.005]) ** 2)
    now = replace(START, displacement=far, pose=Pose2(9.0, 9.0, 0.0), dead_reckoned=True)
    found = residuals(START, now, SPEC)
    assert (found["base_mm"], found["base_deg"]) == pytest.approx((50.0, math.degrees(0.2)))
    assert (found["base_unsure_mm"], found["base_unsure_deg"]) == pytest.approx((60.0, math.degrees(0.015)))
    lost = residuals(START, replace(now, pose_sigma=(math.inf, math.inf), dead_reckoned=False), SPEC)
    assert lost["base_unsure_mm"] == math.inf


def test_by_wheels_alone_only_what_was_added_is_unsure() -> None:
    stood = replace(START, pose_sigma=(0.03, 0.02), dead_reckoned=True)
    found = residuals(stood, replace(stood, pose_sigma=(0.05, 0.025)), SPEC)
    assert found["base_unsure_mm"] == pytest.approx(3 * 40.0)
    assert found["base_unsure_deg"] == pytest.approx(math.degrees(3 * 0.015))
    assert residuals(stood, replace(stood, pose_sigma=(0.01, 0.01)), SPEC)["base_unsure_mm"] == 0.0


def test_each_residual_has_its_limit_and_the_base_its_room() -> None:
    spec = make_spec((True, False, False))
    assert residuals(START, START, spec).limits == {
        "base_mm": 40.0,
        "base_deg": 2.0,
        "base_unsure_mm": 40.0,
        "base_unsure_deg": 2.0,
        "gripper_mm": 1.0,
        "held": 0.0,
        "joints_deg": 0.5,
        "slides_mm": 3.0,
        "object cup mm": 8.0,
        "object pen mm": 8.0,
    }
    within = residuals(START, START, spec, 0.012).limits
    assert (within["base_mm"], within["base_unsure_mm"]) == pytest.approx((12.0, 12.0))
    assert residuals(START, START, spec, 9.0).limits["base_mm"] == 40.0


@pytest.mark.parametrize(("off_mm", "is_moved"), [(40.0, False), (40.001, True), (math.nan, True)])
def test_moved_is_what_is_beyond_its_limit_or_not_known(off_mm: float, is_moved: bool) -> None:
    stood = replace(START, pose=Pose2(0.0, 0.0, 0.0), pose_sigma=(9.0, 9.0))
    off = residuals(stood, replace(stood, pose=Pose2(off_mm / 1e3, 0.0, 0.0)), make_spec()).moved
    assert list(off) == ["base_mm"] * is_moved


@pytest.mark.parametrize("name", ["unsure_box", "base_unsure_mm", "mm", "cup mm", ""])
def test_an_object_of_any_name_counts_as_motion(name: str) -> None:
    stood = replace(START, seen={name: (1.0, 0.0, 0.5)})
    gone = residuals(stood, replace(stood, seen={}), make_spec()).moved
    assert [(item.kind, item.name, item.value) for item in gone.all] == [
        (ResidualKind.OBJECT, name, math.inf)
    ]


def test_a_snapshot_holds_what_was_read() -> None:
    robot: Any = Robot(arm_at([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]), Fingers(0.03, True))
    at = take_snapshot(robot, {"cup": (1.0, 2.0)})
    assert (at.pose, at.pose_sigma, at.seen, at.dead_reckoned) == (
        robot.pose,
        (0.003, 0.001),
        {"cup": (1.0, 2.0)},
        True,
    )
    assert (at.joints.tolist(), at.joint_command.tolist()) == ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6])
    assert (at.gripper_width, at.gripper_command, at.holding) == (0.03, 0.015, True)
    assert (at.odometry_pose, at.displacement) == (None, None)
    jumps: Any = Robot(jumps=True)
    assert take_snapshot(jumps, {}).odometry_pose == Pose2(7.0, 8.0, 9.0)
    assert take_snapshot_since_start(robot, {}).displacement is robot.localization.displacement
    changed: Any = at
    with pytest.raises(FrozenInstanceError):
        changed.holding = False


def test_a_robot_of_wheels_alone_holds_nothing() -> None:
    robot: Any = Robot()
    at = take_snapshot(robot, {})
    assert (at.joints.size, at.joint_command.size) == (0, 0)
    assert (at.gripper_width, at.gripper_command, at.holding) == (0.0, 0.0, False)
    trace = Trace(robot)
    trace.record()
    (moment,) = trace.moments
    assert moment.joints.size == 0
    assert (moment.pose, moment.grip, moment.odometry_pose) == (robot.pose, 0.0, Pose2(7.0, 8.0, 9.0))


def test_a_trace_keeps_commands_as_they_were() -> None:
    command = np.array([0.1, 0.2, 0.3])
    robot: Any = Robot(SimpleNamespace(command=lambda: command), Fingers(0.03, True))
    trace = Trace(robot)
    trace.record()
    command += 1.0
    trace.record()
    assert [moment.joints.tolist() for moment in trace.moments] == [[0.1, 0.2, 0.3], [1.1, 1.2, 1.3]]
    assert [moment.grip for moment in trace.moments] == [0.015, 0.015]
    assert Moment(robot.pose, command, 0.0).odometry_pose is None


@pytest.mark.parametrize(
    ("width", "presses", "holds"),
    [(0.03, True, True), (0.03, False, False), (MIN_HELD_WIDTH_M, True, False), (0.0021, True, True)],
)
def test_fingers_hold_what_keeps_them_apart(width: float, presses: bool, holds: bool) -> None:
    robot: Any = Robot(gripper=Fingers(width, presses))
    assert is_holding(robot) is holds


@pytest.mark.parametrize(("step", "rests"), [(JOINT_NOISE, True), (1.5 * JOINT_NOISE, False)])
@pytest.mark.parametrize("part", ["arm", "gripper"])
def test_a_robot_rests_when_arm_and_fingers_do(part: str, step: float, rests: bool) -> None:
    """Noise of a joint at rest is not motion; the robot waits for some seconds."""
    count = [0.0]

    def value() -> float:
        return step * count[0]

    arm = SimpleNamespace(joints=lambda: np.array([value()]))
    gripper = SimpleNamespace(width=value)
    robot: Any = Robot(arm, None) if part == "arm" else Robot(None, gripper)
    waiting, periods = settle(robot), 0
    while True:
        try:
            next(waiting)
        except StopIteration as end:
            assert end.value is rests
            break
        count[0] += 0.999
        robot.time += 0.0625
        periods += 1
    assert periods == (REST_PERIODS if rests else round(REST_TIMEOUT_S / 0.0625))
