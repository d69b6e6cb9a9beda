"""Building site: the plan, the obstacles around, and the pose of the base."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box

from .building import Building, name_of_block

VIEW_DISTANCE_M = 0.30  # from the camera down to what it looks at


def surroundings(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """Return the tables, and the waiting and placed blocks, as obstacles for the arm in the base frame."""
    plan = building(model)
    base_T_map = standing(robot, model).inverse().lift()
    boxes = [table.box for table in plan.tables.values()]
    size, blocks = plan.block, model.of(Blocks)
    for placed in blocks.placed:
        middle = placed.pose.lift(placed.height + size[2] / 2)
        boxes.append(Box(middle, size, name_of_block(placed.number)))
    waiting = (item for item in enumerate(plan.supply, start=1) if item[0] not in blocks.taken)
    boxes += [place.body(size, name_of_block(number)) for number, place in waiting]
    return tuple(box.seen_from(base_T_map) for box in boxes)


def standing(robot: Robot, model: ModelView) -> Pose2:
    """Return the pose map_T_base of the base.

    The pose measured at a landmark is returned if the wheels have not moved since that measurement, otherwise
    the pose that the localizer estimates.
    """
    fixed = model.of(Blocks).fixed
    here = fixed is not None and fixed.travel == robot.base.wheel_travel()
    return fixed.pose if fixed is not None and here else robot.pose


def building(model: ModelView) -> Building:
    """Return the building plan; raises `Discrepancy` if the robot has none."""
    blocks = model.of(Blocks)
    if blocks.building is None:
        raise Discrepancy("the task has no building plan", permanent=True, cause=causes.NOT_KNOWN)
    return blocks.building


def seat(plan: Building, number: int) -> LevelPose:
    """Return the pose in the base frame at which the robot's own table carries block `number`, from 1; raises
    `Discrepancy` if the plan has no such seats.
    """
    if not plan.carried:
        raise Discrepancy(
            f"the plan has no seats on the robot's own table (carried), none for block {number}",
            permanent=True,
            cause=causes.NOT_KNOWN,
        )
    return plan.seat(number)
