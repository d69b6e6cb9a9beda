"""PICK_UP_BLOCK: take a block from its known pose."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.building import BlockNumber, name_of_block
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import (
    move_straight,
    move_to_joints,
    move_to_pose,
    move_to_posture,
)
from handcart.primitives.motions.from_above import gripped, gripping, on_level
from handcart.primitives.motions.grip import close, holds, open_to, width_off
from handcart.primitives.motions.pushing import push
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import TAKES_OBJECT
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import MIN_HELD_WIDTH_M, Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, inverse

from .block_view import see_block, why_unseen
from .building import Building
from .building_site import building, seat, standing, surroundings
from .supports import TRAY_NAME, held_on

WAIT_HEIGHT_M = 0.06  # over the grip, where the hand waits before it goes straight down and after it came up
OPENING_CLEARANCE_M = 0.020  # wider than the block
BLOCK_APPROACH_SPEED_M_S = 0.10
BLOCK_TOUCH_FORCE_N = 6.0  # more means that a finger is on the block
THICKNESS_ERROR = 0.002  # [m]


class PickUpBlock(ActionPrimitive):
    """Take a block from above, at the supply or from the robot's own table.

    At the supply, the block is located relative to a landmark.

    The closing fingers centre the block between them and remove its offset in that direction. The offset
    along the fingers remains (Hatano et al. 2000, sections 5.4 and 5.5), unless the camera measures it before
    the grip (parameter `look`).
    """

    number: BlockNumber
    """Number of the block in the building plan."""
    at: Literal["supply", "robot"]
    """Location of the block: the supply, or the robot's own table."""
    look: bool = False
    """Measure the pose of the block with the camera first."""
    stow: bool = False
    """Move the arm home in the end, as it must be before the base drives away."""

    needs: ClassVar = (Arm, Gripper, Camera)
    reads: ClassVar = ("building", "fixed", "placed")
    writes: ClassVar = ("taken",)
    hand: ClassVar = TAKES_OBJECT

    _held: bool = PrivateAttr(default=False)
    _touched: bool = PrivateAttr(default=False)

    @override
    def thing(self, model: ModelView) -> str:
        return name_of_block(self.number)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the block was already placed at its goal or taken from the supply; empty
        otherwise.
        """
        blocks = model.of(Blocks)
        if any(placed.number == self.number for placed in blocks.placed):
            return f"block {self.number} is at its goal already"
        if self.at == "supply" and self.number in blocks.taken:
            return f"block {self.number} was taken from the supply already"
        return ""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        plan = building(model)
        stands = self._stands(robot, model, plan)
        if self.look:
            stands = yield from self._seen(robot, model, plan, stands)
        base_T_grip = gripping(robot, plan.block, stands)
        above = base_T_grip.copy()
        above[2, 3] += WAIT_HEIGHT_M
        yield from move_to_pose(robot, above, around=surroundings(robot, model))
        yield from open_to(robot, plan.block[0] + OPENING_CLEARANCE_M)
        pushed = yield from push(robot, base_T_grip, BLOCK_APPROACH_SPEED_M_S, BLOCK_TOUCH_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, BLOCK_TOUCH_FORCE_N, "N")
            raise Discrepancy("a finger is on the block", measured=felt, cause=causes.ARM_BLOCKED)
        yield from self.intend("the fingers close on the block")
        self._touched = True
        yield from close(robot)
        if robot.gripper.width() <= MIN_HELD_WIDTH_M:
            self._touched = False  # nothing was between the fingers, so nothing was moved
            raise Discrepancy(
                f"the fingers closed on nothing where {name_of_block(self.number)} should be",
                measured=_opening(robot, plan),
                cause=causes.NOT_HELD,
            )
        if not _grips(robot, plan):
            raise Discrepancy(
                "the fingers don't hold a block", measured=_opening(robot, plan), cause=causes.NOT_HELD
            )
        self._held = True
        held = gripped(robot, plan.block)
        yield from move_straight(robot, above, held)
        if self.stow:
            yield from move_to_posture(robot, "home", held, surroundings(robot, model))
        if self.at == "supply":
            model.of(Blocks).taken = (*model.of(Blocks).taken, self.number)
        self.found(width_mm=round(1e3 * robot.gripper.width(), 2))

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the block slips out of the hand."""
        if self._held and not robot.gripper.closed_on_something():
            raise Discrepancy(
                "the block slipped out of the hand",
                measured=_opening(robot, building(model)),
                cause=causes.SLIPPED,
            )

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the fingers press on an object of a block's length."""
        return _grips(robot, building(model))
        yield

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the intended contacts of the hand with the block, and of the block with its supports."""
        own, plan = MeantContact("hand", name_of_block(self.number)), model.of(Blocks).building
        if self.at == "robot":
            return own, MeantContact("held", TRAY_NAME)
        if plan is None or self.number > len(plan.supply):
            return (own,)
        return own, *held_on(plan, plan.supply[self.number - 1], plan.supply)

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Play the motion backwards, which puts the block back, and check the block's pose with a picture.

        Raises:
            NeedsPerson: the block is not seen at its place, or is off by more than the robot's tolerance.
        """
        self._held, blocks = False, model.of(Blocks)
        if self.at == "supply":
            blocks.taken = tuple(number for number in blocks.taken if number != self.number)
        yield from retrace(robot, start, trace)
        if not self._touched:
            return
        plan, back = building(model), robot.arm.command()
        stands = self._stands(robot, model, plan)
        seen = yield from see_block(robot, plan, stands, self.evidence, surroundings(robot, model))
        if seen is None:
            raise NeedsPerson(f"block {self.number} isn't seen at its place", cause=causes.NOT_SEEN)
        off = 1e3 * seen.distance(on_level(stands))
        most = robot.spec.tolerance.object_mm
        if exceeds(off, most):
            moved = Measured("Camera", "block off its place", off, most, "mm")
            raise NeedsPerson(f"block {self.number} isn't at its place", moved, cause=causes.MISPLACED)
        yield from move_to_joints(robot, back, around=surroundings(robot, model))

    def _seen(
        self, robot: Robot, model: ModelView, plan: Building, stands: Transform
    ) -> Generator[None, None, Transform]:
        """Return base_T_block (4, 4) by a picture, from the expected base_T_block `stands` (4, 4)."""
        seen = yield from see_block(robot, plan, stands, self.evidence, surroundings(robot, model))
        if seen is None:
            instead = why_unseen(robot, plan, stands)
            raise Discrepancy(
                f"block {self.number} isn't seen at its planned place: {instead}", cause=causes.NOT_SEEN
            )
        off = seen.relative_to(on_level(stands))
        self.found(seen_x_mm=round(1e3 * off.x, 2), seen_y_mm=round(1e3 * off.y, 2))
        return seen.lift(float(stands[2, 3]))

    def _stands(self, robot: Robot, model: ModelView, plan: Building) -> Transform:
        """Return base_T_block (4, 4) by the building plan and the estimated pose of the base."""
        if self.at == "robot":
            return seat(plan, self.number).pose
        if self.number > len(plan.supply):
            raise Discrepancy(
                f"the supply has {len(plan.supply)} blocks, no block {self.number}",
                permanent=True,
                cause=causes.NOT_KNOWN,
            )
        return np.asarray(inverse(standing(robot, model).lift()) @ plan.supply[self.number - 1].pose)


def unlike_block(robot: Robot, model: ModelView) -> str:
    """Return why the held object cannot be one of the building plan's blocks; empty if it may be one."""
    plan = building(model)
    if _grips(robot, plan):
        return ""
    width, length = 1e3 * robot.gripper.width(), 1e3 * plan.block[0]
    return f"the hand holds no block: what it holds is {width:.1f} mm long, a block {length:.1f} mm"


def _grips(robot: Robot, plan: Building) -> bool:
    return holds(robot, plan.block[0], THICKNESS_ERROR)


def _opening(robot: Robot, plan: Building) -> Measured:
    return width_off(robot, plan.block[0], THICKNESS_ERROR, "the block's length")
