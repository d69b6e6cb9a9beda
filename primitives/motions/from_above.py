"""Poses of a hand that points straight down, above a seen object or around an upright one."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME

from .grip import hand_to_tips

GRIP_DEPTH_M = 0.025  # of a thing's height that the pads cover
_LEFT = transform(rpy=(-math.pi / 2, 0.0, 0.0))

Size = tuple[float, float, float]
"""Size of a thing: length, width, height along its x, y and z, in [m]. Fingers close along its length."""


def pointing_down(place: Pose2, height: float) -> Transform:
    """Return the pose base_T_hand (4, 4) of a hand that points down at a place.

    The hand's x axis points down. Its y axis, along which the fingers close, is opposite to the place's
    heading.

    Args:
        place: position and heading on the base's plane, in the base frame.
        height: height of the hand above that plane, in [m].
    """
    return np.asarray(place.lift(height) @ transform(rpy=(0.0, math.pi / 2, 0.0)) @ _LEFT)


def on_level(pose: Transform) -> Pose2:
    """Return x, y and heading of a pose a_T_b (4, 4) as a pose in the plane, in the same frame a."""
    return Pose2(float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]))


def gripping(robot: Robot, size: Size, base_T_thing: Transform) -> Transform:
    """Return the pose base_T_hand (4, 4) that grips a thing from above, with the finger pads around its top.

    The hand is tilted like the thing, so that an upright thing stays upright on a tilted base.

    Args:
        robot: robot with the hand.
        size: length, width and height of the thing, in [m].
        base_T_thing: (4, 4) pose of the thing, whose origin is the middle of its foot.
    """
    above = size[2] - GRIP_DEPTH_M + hand_to_tips(robot)
    return np.asarray(base_T_thing @ pointing_down(Pose2(0.0, 0.0, 0.0), above))


def gripped(robot: Robot, size: Size) -> Box:
    """Return the box of a thing that the hand holds from above, posed in the hand frame.

    Args:
        robot: robot with the hand.
        size: length, width and height of the thing, in [m].
    """
    length, width, height = size
    middle = transform((hand_to_tips(robot) - GRIP_DEPTH_M + height / 2, 0.0, 0.0))
    return Box(middle, (height, length, width), HELD_NAME)
