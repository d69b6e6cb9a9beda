"""STACK: put the held block down where it goes."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Blocks, Placed
from handcart.primitives.blocks.building import BlockNumber, name_of_block
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose, move_to_posture
from handcart.primitives.motions.from_above import gripped, gripping, on_level, pointing_down
from handcart.primitives.motions.grip import open_to
from handcart.primitives.motions.pushing import push, relax
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import LETS_GO
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, raised
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.suspension.fixation import placing_posture, split_goal

from .base_correction import METHOD_CORRECTIONS, FixOnce, Method, OnRobot, fixation
from .block_view import see_block
from .building import Building, LandmarkPlan
from .building_site import VIEW_DISTANCE_M, building, seat, surroundings
from .fixate import landmark_of
from .fixating import Rule, fixate, fixed_by, planned_view, sought
from .pick_up_block import OPENING_CLEARANCE_M, WAIT_HEIGHT_M, unlike_block
from .supports import TRAY_NAME, held_on

GUARDED_DESCENT_M = 0.010  # above the expected contact, where the guarded descent begins
CONTACT_OVERTRAVEL_M = 0.012  # below it, where there should have been contact
FAST, SLOW = 0.10, 0.02  # [m/s]
TOUCHDOWN_FORCE_N = 4.0
DESCENT_MAX_FORCE_N = 12.0  # on the way down
MOST_OFF = 0.008  # [m] from its goal at which a block still counts as put there
MOST_TURNED_RAD = math.radians(3.0)  # the same of its heading


class Stack(ActionPrimitive):
    """Move the held block over its goal, lower it until it touches down, let go, withdraw, and look at it.

    The base is at a place, and the posture of the arm is corrected for the base's actual pose (Hatano et
    al. 2000, eq. 7). This pose is known from the last fixation, a measurement at a landmark. Since then the
    base has turned and tilted, and `method` decides how this is corrected:

    - `fix_once`: not at all, as in the paper.
    - `model`: by the prediction of the suspension's model (eq. 12).
    - `imu`: by the inertial sensors.
    - `fix_again`: the landmark is viewed once more, with the block in the hand.
    - `fix_again_model`: as `fix_again`, fused with the earlier fixation; from then on as `model`.
    - `fix_again_imu`: as `fix_again_model`, but with the turn measured by gyros, and the tilt that the model
      does not predict by accelerometers.
    - `servo`: a landmark next to the goal is viewed.
    """

    number: BlockNumber
    """Number of the block in the building plan."""
    onto: Literal["goal", "robot"]
    """Destination: its goal, or its seat on the robot's own table."""
    method: Method = "fix_again_model"
    """Correction of the base's turn and tilt."""
    rule: Rule = "residual"
    """Stop rule of a fixation; see FIXATE."""
    stow: bool = False
    """Move the arm home in the end, as it must be before the base drives away."""

    needs: ClassVar = (Arm, Gripper, Camera)
    reads: ClassVar = ("places", "building", "taken")
    writes: ClassVar = ("fixed", "placed")
    hand: ClassVar = LETS_GO

    _placed: Placed | None = PrivateAttr(default=None)
    _correction: FixOnce = PrivateAttr(default_factory=FixOnce)
    """Correction of the base's turn and tilt in this attempt."""

    @override
    def thing(self, model: ModelView) -> str:
        return name_of_block(self.number)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a message if the hand does not hold a block as the building plan describes them; empty
        otherwise.
        """
        return unlike_block(robot, model)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        plan = building(model)
        correction = self._correction = self._begun(robot)
        held = gripped(robot, plan.block)
        goal = self._goal(plan)
        around = surroundings(robot, model)
        if correction.views_landmark:
            yield from self._view(robot, model, fixation(model).landmark, None)
        over = self._over_viewed if correction.views_goal else self._over
        grip = yield from over(robot, model, goal, around)
        yield from move_straight(robot, raised(grip, WAIT_HEIGHT_M), held)
        if (yield from correction.measure_over_goal(robot)):
            grip = gripping(robot, plan.block, correction.base_T_block(robot, model, goal, 0))
        yield from self._lower(robot, grip)
        yield from self.intend("the fingers let the block go")
        yield from open_to(robot, plan.block[0] + OPENING_CLEARANCE_M)
        yield from move_straight(robot, raised(robot.arm_model.forward(robot.arm.command()), WAIT_HEIGHT_M))
        if self.onto == "goal":
            yield from self._check(robot, model, plan, goal)
        if self.stow:
            yield from move_to_posture(robot, "home", around=surroundings(robot, model))

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Play the motion backwards, which takes the block into the hand again: it is not at its goal."""
        blocks = model.of(Blocks)
        blocks.placed = tuple(placed for placed in blocks.placed if placed is not self._placed)
        yield from super().restore(robot, model, start, trace)

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Return the intended contacts of the hand with the block, and of the block with its supports."""
        own, plan = MeantContact("hand", name_of_block(self.number)), model.of(Blocks).building
        if self.onto == "robot":
            return own, MeantContact("held", TRAY_NAME)
        if plan is None or self.number > len(plan.goals):
            return (own,)
        return own, *held_on(plan, plan.goals[self.number - 1], plan.goals)

    def _goal(self, plan: Building) -> LevelPose:
        if self.onto == "robot":
            return seat(plan, self.number)
        if self.number > len(plan.goals):
            raise Discrepancy(
                f"the plan has {len(plan.goals)} goals, none for block {self.number}",
                permanent=True,
                cause=causes.NOT_KNOWN,
            )
        return plan.goals[self.number - 1]

    def _begun(self, robot: Robot) -> FixOnce:
        """Return the correction of an attempt; raise `Discrepancy` if the robot lacks a sensor for it."""
        chosen = METHOD_CORRECTIONS[self.method]
        if chosen.needs_imu and robot.spec.imu is None:
            raise Discrepancy(
                f"the method {self.method} needs inertial sensors", permanent=True, cause=causes.UNSUITABLE
            )
        return chosen() if self.onto == "goal" else OnRobot()

    def _over(
        self, robot: Robot, model: ModelView, goal: LevelPose, around: Sequence[Box]
    ) -> Generator[None, None, Transform]:
        """Bring the block over its goal; return base_T_hand (4, 4) where it will touch down."""
        blocks, size, correction = model.of(Blocks), building(model).block, self._correction
        swing = _is_swing(robot, gripping(robot, size, correction.base_T_block(robot, model, goal, 0)))
        grip = gripping(robot, size, correction.base_T_block(robot, model, goal, swing))
        yield from move_to_pose(robot, raised(grip, WAIT_HEIGHT_M), gripped(robot, size), around)
        if self.onto == "goal" and blocks.fixed is not None:
            blocks.fixed = blocks.fixed._replace(swings=blocks.fixed.swings + swing)
        return grip

    def _over_viewed(
        self, robot: Robot, model: ModelView, goal: LevelPose, around: Sequence[Box]
    ) -> Generator[None, None, Transform]:
        """View the landmark beside the goal; return base_T_hand (4, 4) where the block will touch down."""
        plan = building(model)
        name = plan.goals[self.number - 1].landmark
        if name is None:
            raise Discrepancy(
                f"the plan has no landmark beside the goal of block {self.number}",
                permanent=True,
                cause=causes.NOT_KNOWN,
            )
        mark = landmark_of(model, name)
        planned = model.places[self._place(model, mark)].pose
        planned_T_block = split_goal(goal.pose, planned.lift())
        hover = gripping(robot, plan.block, planned_T_block)
        hover[2, 3] = self._view_height(robot, mark.height_m)
        error = yield from self._view(robot, model, name, hover)
        return gripping(robot, plan.block, placing_posture(error, planned_T_block))

    def _place(self, model: ModelView, mark: LandmarkPlan) -> str:
        """Return the name of the base's target place."""
        blocks = model.of(Blocks)
        return blocks.fixed.place if blocks.fixed is not None else mark.place

    def _view_height(self, robot: Robot, surface: float) -> float:
        """Return the height of the hand for a view of a surface, in [m]."""
        level = pointing_down(Pose2(0.0, 0.0, 0.0), 0.0)
        return surface + VIEW_DISTANCE_M - float((level @ robot.camera.hand_T_camera)[2, 3])

    def _view(
        self, robot: Robot, model: ModelView, name: str, hand: Transform | None
    ) -> Generator[None, None, Transform]:
        """View a landmark with the block in the hand; return the travelling error planned_T_base (4, 4)."""
        blocks, plan, mark = model.of(Blocks), building(model), landmark_of(model, name)
        place = self._place(model, mark)
        planned, before = model.places[place].pose, blocks.fixed
        view = planned_view(robot, mark, planned, hand)
        swing = _is_swing(robot, view.base_T_hand)
        stands, covariance, known = robot.pose, robot.localization.covariance, None
        if before is not None:
            stands, covariance, known = before.pose, before.covariance, before.pose.relative_to(planned)
        found = yield from fixate(
            robot,
            view,
            sought(name, plan.landmarks, planned, stands, covariance),
            self.rule,
            self.evidence,
            gripped(robot, plan.block),
            surroundings(robot, model),
            looks=self._correction.looks,
            known=known,
        )
        self.found(frames=found.frames)
        blocks.fixed = fixed_by(robot, name, place, planned, found)
        blocks.fixed = yield from self._correction.take_view(robot, before, blocks.fixed, swing)
        return found.planned_T_base.lift()

    def _lower(self, robot: Robot, grip: Transform) -> Periods:
        """Lower the block until it touches down, at the latest a little below base_T_hand `grip` (4, 4)."""
        pushed = yield from push(robot, raised(grip, GUARDED_DESCENT_M), FAST, DESCENT_MAX_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, DESCENT_MAX_FORCE_N, "N")
            raise Discrepancy("an obstacle is at the block's goal", measured=felt, cause=causes.OCCUPIED)
        pushed = yield from push(robot, raised(grip, -CONTACT_OVERTRAVEL_M), SLOW, TOUCHDOWN_FORCE_N)
        if not pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, TOUCHDOWN_FORCE_N, "N")
            raise Discrepancy(
                "the block doesn't touch down where its support should be",
                measured=felt,
                cause=causes.NO_SUPPORT,
            )
        touched = float(robot.base_T("hand")[2, 3] - grip[2, 3])
        yield from relax(robot)
        self.found(touched_mm=round(1e3 * touched, 2))

    def _check(self, robot: Robot, model: ModelView, plan: Building, goal: LevelPose) -> Periods:
        """Measure the placed block with the camera; raise `Discrepancy` if it is off its goal."""
        blocks = model.of(Blocks)
        expected = self._correction.base_T_block(robot, model, goal, 0)
        seen = yield from see_block(robot, plan, expected, self.evidence, surroundings(robot, model))
        if seen is None:
            raise Discrepancy(f"block {self.number} isn't seen where it was put", cause=causes.NOT_SEEN)
        off = seen.relative_to(on_level(expected))
        self.found(seen_x_mm=round(1e3 * off.x, 2), seen_y_mm=round(1e3 * off.y, 2))
        self.found(seen_turned_deg=round(math.degrees(off.theta), 2))
        far = float(np.hypot(off.x, off.y))
        if exceeds(far, MOST_OFF):
            apart = Measured("Camera", "block off its goal", 1e3 * far, 1e3 * MOST_OFF, "mm")
            raise Discrepancy(
                f"block {self.number} is next to its goal", measured=apart, cause=causes.MISPLACED
            )
        if exceeds(abs(off.theta), MOST_TURNED_RAD):
            turned = Measured(
                "Camera",
                "block turned against its goal",
                math.degrees(abs(off.theta)),
                math.degrees(MOST_TURNED_RAD),
                "deg",
            )
            raise Discrepancy(
                f"block {self.number} is turned against its goal", measured=turned, cause=causes.MISPLACED
            )
        self._placed = Placed(self.number, goal.floor, goal.height_m)
        blocks.placed = (*blocks.placed, self._placed)


def _is_swing(robot: Robot, base_T_hand: Transform) -> int:
    """Return 1 if the motion with the load is long enough to turn the base, otherwise 0."""
    here = robot.arm_model.forward(robot.arm.command())
    across = float(np.linalg.norm(base_T_hand[:2, 3] - here[:2, 3]))
    return int(across >= robot.spec.suspension.swing_from_mm / 1e3)
