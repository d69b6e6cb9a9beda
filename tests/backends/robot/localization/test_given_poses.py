"""Poses that a localization is given: measured, found on the map, forgotten, or those of a checkpoint."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.robot.localization.localization import Localization
from handcart.backends.robot.localization.localizations import localization_of
from handcart.robotics.geometry.pose2 import Pose2

from .sensor_stubs import STANDS, START, Room, Stub, Wheels, room


def seeing(localizer: str, wheels: Wheels, lidar: Room) -> Localization:
    """Return the localization of a cart in a room, whose scans are interpreted."""
    spec = load_robot("cart").model_copy(update={"localizer": localizer})
    return localization_of(Stub(wheels, lidar), spec, START, room(), Lidar(lidar, spec))


@pytest.mark.parametrize("sigma", [(0.0003, 0.0004), (0.004, 0.002)])
@pytest.mark.parametrize("off_m", [0.0, 0.02])
def test_push_after_a_measured_pose_is_found(sigma: tuple[float, float], off_m: float) -> None:
    """Also where the scans' pose is off by the map's error, which is no push."""
    lidar = Room()
    found = seeing("scan", Wheels(), lidar)
    for _ in range(40):
        found.update(STANDS)
    measured = Pose2(START.x + off_m, START.y, START.theta)
    found.found_at(measured, sigma)
    assert found.sigma[0] == pytest.approx(math.hypot(sigma[0], 0.004))
    found.set_state(found.state())
    for _ in range(60):
        found.update(STANDS)
    assert found.displacements == 0
    assert found.pose == measured
    lidar.pose = START.compose(Pose2(0.05, 0.0, 0.0))
    for _ in range(30):
        found.update(STANDS)
    assert found.displacements == 1
    assert found.pose == pytest.approx(lidar.pose, abs=0.02)


def test_state_from_before_measured_poses_were_kept_is_read() -> None:
    found = seeing("scan", Wheels(), Room())
    state = found.state()
    del state["wheels"]["_by_scans"]
    found.set_state(state)
    assert found.pose == pytest.approx(START, abs=0.02)


@pytest.mark.parametrize("is_located", [True, False])
def test_keyframes_among_unmapped_things_survive_a_checkpoint(is_located: bool) -> None:
    wheels, lidar = Wheels(), Room()
    found = seeing("scan", wheels, lidar)
    if not is_located:
        found.forget_pose()
    for _ in range(10):
        wheels.roll(0.05, 0.05)
        lidar.pose = lidar.pose.compose(Pose2(0.05, 0.0, 0.0))
        found.update(STANDS)
    state = found.state()
    assert len(state["keyframes"]["_poses"]) > 0
    resumed = seeing("scan", Wheels(), Room())
    resumed.set_state(state)
    assert np.array_equal(resumed.state()["keyframes"]["_poses"], state["keyframes"]["_poses"])
    assert np.array_equal(resumed.state()["keyframes"]["_points"], state["keyframes"]["_points"])


@pytest.mark.parametrize("found_by", ["locate", "follow_map", "forget_pose"])
def test_a_held_base_that_is_lost_is_not_once_it_is_located(found_by: str) -> None:
    """By its pose on the map, on a new map, or on a local map until it is known."""
    wheels, lidar = Wheels(), Room()
    found = seeing("odometry", wheels, lidar)
    for _ in range(10):
        found.update(STANDS)
    for period in range(300):
        wheels.roll(0.01, 0.01)
        if period > 40:  # until then something holds it
            lidar.pose = lidar.pose.compose(Pose2(0.01, 0.0, 0.0))
        found.update(STANDS)
        if found.lost is not None:
            break
    assert found.lost is not None
    assert "something held it" in found.lost.why
    if found_by == "locate":
        found.locate(lidar.pose, 1e-4 * np.eye(3))
    elif found_by == "follow_map":
        assert found.map_field is not None
        found.follow_map(found.map_field, lidar.pose, 1e-4 * np.eye(3))
    else:
        found.forget_pose()
    assert found.lost is None
    found.update(STANDS)
    assert found.lost is None
