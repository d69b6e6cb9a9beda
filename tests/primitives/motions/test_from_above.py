"""Tests of hand poses above and around upright objects."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.motions.from_above import GRIP_DEPTH_M, gripped, gripping, pointing_down
from handcart.primitives.motions.grip import holds, width_off
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse, transform

TIP = 0.11
SIZE = (0.05, 0.03, 0.08)
STANDS = LevelPose(x_m=0.4, y_m=-0.1, height_m=0.7, heading_deg=30.0)


def robot(width: float = 0.05, pressing: bool = True) -> Robot:
    """One whose finger tips are 110 mm ahead of its hand."""
    gripper = SimpleNamespace(width=lambda: width, closed_on_something=lambda: pressing)
    spec = SimpleNamespace(finger_shape=SimpleNamespace(tip=TIP))
    return cast(Any, SimpleNamespace(spec=spec, gripper=gripper))  # type: ignore[no-any-return]


def test_the_hand_points_down_and_its_fingers_close_along_the_place() -> None:
    pose = pointing_down(Pose2(1.0, 2.0, np.radians(30.0)), 0.5)
    assert pose[:3, 3] == pytest.approx((1.0, 2.0, 0.5))
    assert pose[:3, 0] == pytest.approx((0.0, 0.0, -1.0), abs=1e-12)
    assert pose[:3, 1] == pytest.approx((-np.cos(np.radians(30.0)), -0.5, 0.0), abs=1e-12)


@pytest.mark.parametrize("leans", [(0.0, 0.0, 0.0), (0.01, -0.02, 0.0)])
def test_pads_cover_the_top_and_the_held_body_is_the_one_there(leans: Any) -> None:
    """On a tilted base, an upright object is tilted in the base frame, and the hand as well."""
    lean = STANDS.pose @ transform(rpy=leans) @ inverse(STANDS.pose)
    base_T_hand = gripping(robot(), SIZE, lean @ STANDS.pose)
    tips = inverse(lean) @ base_T_hand @ (TIP, 0.0, 0.0, 1.0)
    assert tips[:3] == pytest.approx((0.4, -0.1, 0.7 + SIZE[2] - GRIP_DEPTH_M))
    standing = STANDS.body(SIZE, "it")
    held = gripped(robot(), SIZE).seen_from(inverse(lean) @ base_T_hand)
    corners = np.array([[x, y, z, 1.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])

    def places(pose: Any, size: Any) -> Any:
        found = (corners * (*(np.array(size) / 2), 1.0)) @ pose.T
        return found[np.lexsort(found.round(6).T)]

    assert places(held.pose, held.size) == pytest.approx(places(standing.pose, standing.size), abs=1e-12)


@pytest.mark.parametrize(
    ("width", "pressing", "held"),
    [
        (0.05, True, True),
        (0.054, True, True),
        (0.056, True, False),
        (0.044, True, False),
        (0.05, False, False),
    ],
)
def test_what_is_as_wide_and_pressed_on_is_held(width: float, pressing: bool, held: bool) -> None:
    assert holds(robot(width, pressing), 0.05, 0.005) is held


def test_how_far_off_is_measured() -> None:
    off = width_off(robot(0.057), 0.05, 0.005, "the can's width")
    assert off.value == pytest.approx(7.0)
    assert (off.what, off.limit, off.unit) == ("opening off the can's width", 5.0, "mm")
