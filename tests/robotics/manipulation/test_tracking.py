"""Following a path from a standing base: on it, within limits, and from where the base really stopped."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.tracking.tool_follower import ToolFollower
from handcart.robotics.manipulation.tracking.tracking_limits import ArmLoad
from handcart.robotics.manipulation.tracking.tracking_time import TrackingLimits, time_evenly, time_tracking

from .seams import arched, five_joint_urdf
from .tool_errors import tool_errors

BASE = Pose2(0.1, -1.2, 1.3)
PERIOD = 0.02
LIMITS = TrackingLimits(0.1, np.full(5, 3.0), np.full(5, 60.0), 10.0)


@pytest.fixture(scope="module")
def five() -> ArmModel:
    return ArmModel(five_joint_urdf(), [f"j{number}" for number in range(1, 6)])


@pytest.fixture(scope="module")
def follower(five: ArmModel) -> ToolFollower:
    return ToolFollower(five, FreeTurn.VERTICAL, np.radians(60.0))


@pytest.fixture(scope="module")
def path() -> ToolPath:
    return arched(60, span=1.2, rise=0.2)


@pytest.fixture(scope="module")
def planned(follower: ToolFollower, path: ToolPath) -> np.ndarray:
    near = np.append(PitchArm().joints(np.array(BASE), path)[0], 0.0)
    return follower.joints(path, BASE.lift(), near)


def test_tool_follows_the_path_in_the_closed_forms_branch(
    follower: ToolFollower, path: ToolPath, planned: np.ndarray
) -> None:
    assert tool_errors(follower.arm, path, BASE.lift(), planned).max() < 1e-7
    np.testing.assert_allclose(planned[:, :4], PitchArm().joints(np.array(BASE), path), atol=1e-6)


def test_where_the_base_really_stopped_is_taken_in(
    follower: ToolFollower, path: ToolPath, planned: np.ndarray
) -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        x, y, angle, roll, pitch = rng.normal(size=5) * (0.01, 0.01, 0.02, 0.005, 0.005)
        stopped = BASE.lift() @ transform((x, y, 0.0), (roll, pitch, angle))
        assert tool_errors(follower.arm, path, stopped, planned).max() > 0.002
        again = follower.joints(path, stopped, planned[0])
        assert tool_errors(follower.arm, path, stopped, again).max() < 1e-7


def test_joint_that_its_limits_hold_still_changes_nothing(path: ToolPath, planned: np.ndarray) -> None:
    """A spare joint of no range."""
    locked = '<joint name="j6" type="revolute"><parent link="e"/><child link="f"/><axis xyz="1 0 0"/>'
    locked += '<limit lower="0" upper="0" velocity="1.5" effort="60"/></joint><link name="f"/>'
    urdf = five_joint_urdf().replace('<joint name="tip" type="fixed"><parent link="e"/>', f"{locked}<joint "
                                     'name="tip" type="fixed"><parent link="f"/>')  # fmt: skip
    six = ToolFollower(
        ArmModel(urdf, [f"j{number}" for number in range(1, 7)]), FreeTurn.VERTICAL, np.radians(60.0)
    )
    angles = six.joints(path, BASE.lift(), np.append(planned[0], 0.0))
    assert tool_errors(six.arm, path, BASE.lift(), angles).max() < 1e-7
    assert np.abs(angles[:, 5]).max() < 1e-9


def test_limits_hold_at_every_sample_with_the_tool_on_its_path(
    five: ArmModel, follower: ToolFollower, path: ToolPath, planned: np.ndarray
) -> None:
    timed = time_tracking(five, path, planned, LIMITS, PERIOD)
    assert timed.use.violations == 0
    assert ArmLoad(five).use(timed.set_points, PERIOD, LIMITS.torque).violations == 0
    steps = np.diff(timed.lengths)
    assert (steps >= 0.0).all()
    assert steps.max() <= LIMITS.speed * PERIOD * (1 + 1e-9)
    assert np.median(steps) > 0.95 * LIMITS.speed * PERIOD  # as fast as asked
    assert timed.lengths[0] == 0.0
    assert timed.lengths[-1] == pytest.approx(path.length)
    truth = arched(6000, span=1.2, rise=0.2).points
    tips = np.array([(BASE.lift() @ five.forward(q))[:3, 3] for q in timed.set_points])
    gaps = np.linalg.norm(tips[:, None] - truth[None], axis=2).min(axis=1)
    assert gaps.max() < 2e-4


def test_what_is_asked_too_fast_is_slowed_down(five: ArmModel, path: ToolPath, planned: np.ndarray) -> None:
    timed = time_tracking(five, path, planned, LIMITS._replace(speed=5.0), PERIOD)
    assert timed.use.violations == 0
    assert max(timed.use.speed.max(), timed.use.torque.max()) > 0.5
    assert len(timed.set_points) * PERIOD < 0.5 * path.length / LIMITS.speed


@pytest.mark.parametrize("speed", [0.05, 0.1, 5.0])
def test_beside_a_driving_base_the_tool_keeps_one_speed(
    five: ArmModel, path: ToolPath, planned: np.ndarray, speed: float
) -> None:
    """But for ramps at its ends, and as much slower as leaves joints something for feedback."""
    timed = time_evenly(five, path, planned, LIMITS._replace(speed=speed), 0.2, PERIOD)
    steps = np.diff(timed.lengths) / PERIOD
    top = steps.max()
    assert timed.use.violations == 0
    assert timed.use.speed.max() <= 0.75
    assert top <= speed * (1 + 1e-9)
    assert (steps > 0.99 * top).mean() > (0.3 if speed < 1.0 else 0.0)
    assert np.abs(np.diff(steps)).max() <= 1.01 * 0.2 * PERIOD
    assert (timed.lengths[0], timed.lengths[-1]) == pytest.approx((0.0, path.length))


def test_beside_a_driving_base_an_arm_too_weak_is_refused(
    five: ArmModel, path: ToolPath, planned: np.ndarray
) -> None:
    with pytest.raises(Untrackable, match="allowed: 9"):
        time_evenly(five, path, planned, LIMITS._replace(torque=np.full(5, 10.0)), 0.2, PERIOD)
    with pytest.raises(ValueError, match="must be above zero"):
        time_evenly(five, path, planned, LIMITS, 0.0, PERIOD)


def test_an_arm_too_weak_to_hold_itself_is_refused(
    five: ArmModel, path: ToolPath, planned: np.ndarray
) -> None:
    with pytest.raises(Untrackable, match=r"point 0 of the path takes .* Nm of 'j2'; allowed: 9\.8 Nm"):
        time_tracking(five, path, planned, LIMITS._replace(torque=np.full(5, 10.0)), PERIOD)
    with pytest.raises(ValueError, match="must be above zero"):
        time_tracking(five, path, planned, LIMITS._replace(speed=0.0), PERIOD)


def test_out_of_reach_the_first_point_and_the_nearest_are_named(
    follower: ToolFollower, planned: np.ndarray
) -> None:
    longer = arched(120, span=2.4, rise=0.2)
    first = int(np.argmin(np.linalg.norm(longer.points - (0.0, 0.0, 0.9), axis=1)))
    with pytest.raises(Untrackable, match=r"can't be reached.*nearest that can be reached") as caught:
        follower.joints(longer.part(first, 119), BASE.lift(), planned[30])
    assert caught.value.nearest is not None
    bad = longer.points[first + caught.value.index]
    assert 0.0 < np.linalg.norm(caught.value.nearest - bad) < 0.1


def test_an_arm_with_joints_to_spare_keeps_away_from_its_limits(arm: ArmModel) -> None:
    middle, half = 0.5 * (arm.lower + arm.upper), 0.5 * (arm.upper - arm.lower)
    start = np.radians([-93.994, -63.025, 152.223, -93.988, -90.058, 170.0])  # the last one near its limit
    start = np.clip(start, middle - 0.97 * half, middle + 0.97 * half)
    poses = np.tile(arm.forward(start), (80, 1, 1))
    poses[:, 2, 3] += np.linspace(0.0, 0.12, 80)
    path = tool_path(poses)
    follower = ToolFollower(arm, FreeTurn.TOOL)
    found = follower.joints(path, np.eye(4), start)
    assert tool_errors(follower.arm, path, np.eye(4), found).max() < 1e-7
    near = np.abs((found - middle) / half).max(axis=1)
    assert near[-1] < near[0] - 0.02
    assert np.abs(np.diff(found, axis=0)).max() < 0.1
