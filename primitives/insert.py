"""INSERT: push the held book into its slot."""

from __future__ import annotations

from collections.abc import Generator
from typing import ClassVar, Literal

import numpy as np
from pydantic import PrivateAttr

from backends.arm import Arm
from backends.gripper import Gripper
from backends.range_sensor import RangeSensor
from backends.robot import Robot
from robotics.geometry.transform import Transform, inverse, transform
from robotics.manipulation.motion_planner import plan_straight

from .action_primitive import ActionPrimitive, Periods
from .discrepancy import Discrepancy
from .grip import HAND_TO_TIPS, holds
from .place_name import PlaceName
from .pushing import Pushed, push
from .shelf_front import measure_shelf
from .taught import taught_postures
from .world_model import ModelView

TIPS_BEFORE = 0.007  # [m] that the finger tips stay before the shelf's front: spines stand 3 mm before it
SPEED = 0.02  # [m/s]
JAM = 7.0  # [N]: sliding in takes 2; a neighbour is pushed back from 10 on
WIGGLES = ((0.0, 0.0), (0.003, 0.035), (-0.003, -0.035))  # to the left in [m], turned left by [rad]
REACHED = 0.004  # [m]


class Insert(ActionPrimitive):
    """Push the held book straight into its slot, until the finger tips stand just before the spines.

    Where it enters is where APPROACH brought it; how far it goes is measured on the shelf's front. A book
    that jams is pulled out and tried a few millimetres beside; one that jams everywhere is a Fail, pulled
    back to where it was. Taught, the hand plays back `insert_1` and on, whatever the range sensor says.
    """

    shelf: PlaceName
    """The place before the shelf."""
    method: Literal["planned", "taught"] = "planned"
    """How the hand finds its way."""
    wiggle: bool = True
    """Whether a book that jams is tried beside."""

    needs: ClassVar = (Arm, Gripper, RangeSensor)
    reads: ClassVar = ("places", "book")

    _goal: Transform | None = PrivateAttr(default=None)
    """base_T_hand at the end (4, 4)."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        if model.book is None or not holds(robot, model.book):
            raise Discrepancy("the hand doesn't hold the book")
        base_T_hand = robot.arm_model.forward(robot.arm.command())
        ways = WIGGLES if self.wiggle and self.method == "planned" else WIGGLES[:1]
        if self.method == "taught":
            self._goal = robot.arm_model.forward(taught_postures(robot, "insert", 1)[-1])
        else:
            base_T_shelf = yield from measure_shelf(robot, model.places[self.shelf])
            self._goal = _end(base_T_shelf, base_T_hand)
        for number, (aside, turn) in enumerate(ways, start=1):
            beside = transform((0.0, aside, 0.0), (0.0, 0.0, turn))
            pushed = yield from self._try(robot, base_T_hand @ beside, self._goal @ beside)
            self.found(force_n=round(pushed.force, 1), tries=number)
            if not pushed.met:
                return
        raise Discrepancy(f"the book jams: it is pressed with {pushed.force:.0f} N")
