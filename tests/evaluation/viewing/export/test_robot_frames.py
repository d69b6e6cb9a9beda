"""Frames of the robot in an exported run."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.evaluation.viewing.export.run_mcap import robot_frames
from handcart.evaluation.viewing.playback.scenery import RobotShape
from handcart.evaluation.viewing.playback.seven import transforms
from handcart.robotics.geometry.transform import transform

JOINT = '<joint name="{1}" type="fixed"><origin xyz="{2}"/><parent link="{0}"/><child link="{1}"/></joint>'


def shape(root: str, *joints: str) -> RobotShape:
    links = "".join(f'<link name="{name}"/>' for name in {root, *(joint.split('"')[1] for joint in joints)})
    urdf = f'<robot name="r">{links}{"".join(joints)}</robot>'
    return RobotShape(name="r", urdf=urdf, footprint_m=0.3, base_t_sensor=(0.2, 0.0, math.pi / 2))


def test_a_root_link_beside_the_base_is_where_it_is() -> None:
    joints = (
        JOINT.format("footprint", "base", "0.1 0 0.05"),
        JOINT.format("base", "range_sensor", "0.2 0 0.3"),
    )
    frames = robot_frames(shape("footprint", *joints))
    assert frames.root == "footprint"
    assert frames.base_T_root == pytest.approx(transform((-0.1, 0.0, -0.05)))
    expected = transform((0.3, 0.0, 0.35), (0.0, 0.0, math.pi / 2))
    assert transforms(frames.root_T_lidar[None])[0] == pytest.approx(expected)


def test_a_base_that_is_the_root_carries_the_lidar_at_its_height() -> None:
    frames = robot_frames(shape("base", JOINT.format("base", "range_sensor", "0.2 0 0.3")))
    assert np.array_equal(frames.base_T_root, np.eye(4))
    assert frames.root_T_lidar[:3] == pytest.approx((0.2, 0.0, 0.3))
