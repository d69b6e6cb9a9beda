"""The hand that points straight down: over landmarks, and about blocks."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.contract.discrepancy import Discrepancy
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.grip import hand_to_tips
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.motions.collision_model import HELD

from .building import Building, name_of_block

BITE = 0.025  # [m] of a block's height that the pads cover
VIEW = 0.30  # [m] from the camera down to what it looks at


def pointing_down(place: Pose2, height: float) -> Transform:
    """base_T_hand (4, 4): the hand's x down, its y (along which the fingers close) against the place's x."""
    return np.asarray(place.lift(height) @ transform(rpy=(0.0, math.pi / 2, 0.0)) @ _LEFT)


_LEFT = transform(rpy=(-math.pi / 2, 0.0, 0.0))


def gripping(robot: Robot, plan: Building, base_T_block: Transform) -> Transform:
    """base_T_hand (4, 4) about a block: the pads cover the upper 25 mm of its sides."""
    height = float(base_T_block[2, 3]) + plan.block[2] - BITE + hand_to_tips(robot)
    return pointing_down(on_level(base_T_block), height)


def on_level(pose: Transform) -> Pose2:
    """x, y and heading of a pose (4, 4)."""
    return Pose2(float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]))


def held_block(robot: Robot, plan: Building) -> Box:
    """A block as it is gripped, posed in the hand frame."""
    length, width, height = plan.block
    middle = transform((hand_to_tips(robot) - BITE + height / 2, 0.0, 0.0))
    return Box(middle, (height, length, width), HELD)


def surroundings(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """The tables, the blocks that wait and those that were put where they go, posed in the base frame."""
    plan = building(model)
    base_T_map = standing(robot, model).inverse().lift()
    boxes = [table.box for table in plan.tables.values()]
    half, blocks = plan.block[2] / 2, model.of(Blocks)
    feet = [(each.number, each.pose.lift(each.height + half)) for each in blocks.placed]
    waiting = (each for each in enumerate(plan.supply, start=1) if each[0] not in blocks.taken)
    feet += [(number, place.floor.lift(place.height_m + half)) for number, place in waiting]
    boxes += [Box(middle, plan.block, name_of_block(number)) for number, middle in feet]
    return tuple(Box(base_T_map @ box.pose, box.size, box.name) for box in boxes)


def standing(robot: Robot, model: ModelView) -> Pose2:
    """map_T_base: by the landmark where one was seen from here, else as estimated."""
    fixed = model.of(Blocks).fixed
    here = fixed is not None and fixed.travel == tuple(robot.base.wheel_travel())
    return fixed.pose if fixed is not None and here else robot.pose


def building(model: ModelView) -> Building:
    """The building plan; raises `Discrepancy` where the robot has none."""
    blocks = model.of(Blocks)
    if blocks.building is None:
        raise Discrepancy("the task has no building plan", permanent=True)
    return blocks.building
