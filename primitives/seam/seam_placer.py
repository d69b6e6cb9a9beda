"""Placer that divides seams for a robot."""

from __future__ import annotations

import math

from handcart.backends.description.robot_file import RobotFile
from handcart.primitives.motions.working_arm import working_arm
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.manipulation.placement.placements import Work
from handcart.robotics.manipulation.placement.placer import Placer

FREE_TURNS = {"nothing": FreeTurn.NONE, "azimuth": FreeTurn.VERTICAL, "roll": FreeTurn.TOOL}


def work_of(spec: RobotFile, speed: float | None = None) -> Work:
    """Return the speed and force with which the robot's tool follows a path, the axis about which the tool
    may turn freely, and the tolerance of that turn.

    Args:
        spec: robot's file, with the tool.
        speed: speed of the tool, in [m/s]; None: the speed in the robot's file.

    Raises:
        Discrepancy: the robot has no tool.
    """
    tool = spec.tool
    if tool is None:
        raise Discrepancy("the robot's file has no tool", permanent=True, cause=causes.UNSUITABLE)
    tolerance = math.radians(tool.azimuth_tolerance_deg)
    return Work(speed or tool.speed_m_s, tool.force_n, FREE_TURNS[tool.free], tolerance)


def placer_of(spec: RobotFile, speed: float | None = None) -> Placer:
    """Return a planner of base poses from which the robot's arm can move a tool along a seam.

    Args:
        spec: robot's file.
        speed: speed of the tool, in [m/s]; None: the speed in the robot's file.

    Raises:
        Discrepancy: arm or tool cannot do the work.
    """
    try:
        return Placer(working_arm(spec), work_of(spec, speed))
    except ValueError as wrong:
        raise Discrepancy(str(wrong), permanent=True, cause=causes.UNSUITABLE) from None
