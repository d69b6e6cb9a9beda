"""Poses of the hand at blocks and landmarks for the placer of stops, and its contacts there."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.mounted_camera import known_camera, mount_of
from handcart.primitives.blocks.building_site import VIEW_DISTANCE_M
from handcart.primitives.blocks.pick_up_block import (
    BLOCK_APPROACH_SPEED_M_S,
    OPENING_CLEARANCE_M,
    WAIT_HEIGHT_M,
)
from handcart.primitives.blocks.stack import DESCENT_MAX_FORCE_N
from handcart.primitives.driving.standing_room import STAND_MARGIN_M
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.motions.from_above import GRIP_DEPTH_M, pointing_down
from handcart.primitives.motions.working_arm import working_arm
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.manipulation.arms.screw_table import SCREW_TABLE_TYPES, screw_table
from handcart.robotics.manipulation.motions.collision_model import HELD_NAME, CollisionModel
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.placements import Work
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.manipulation.placement.stops import Goal, StopPlacer
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compile_early

HEIGHT_STEP_M = 0.02  # [m] between two heights from which something is looked at

compile_early(screw_table, SCREW_TABLE_TYPES, __name__)


class StopReach:
    """Reach of a robot's arm from a stop, a pose at which the base parks to pick up or put down blocks.

    For blocks of one size, it holds in which poses relative to the base the arm can handle a block without
    collision.
    """

    def __init__(self, spec: RobotFile, block: tuple[float, float, float]) -> None:
        """Prepare a robot.

        Args:
            spec: the robot's file.
            block: length, width, height in [m].

        Raises:
            Discrepancy: the robot lacks arm, gripper or camera, or its arm can do this work nowhere.
        """
        if spec.gripper is None or spec.hand_camera is None:
            lacking = "gripper" if spec.gripper is None else "camera"
            raise Discrepancy(f"the robot's file has no {lacking}", permanent=True, cause=causes.UNSUITABLE)
        arm = working_arm(spec)
        try:
            self.placer = Placer(arm, Work(BLOCK_APPROACH_SPEED_M_S, DESCENT_MAX_FORCE_N, FreeTurn.NONE, 0.0))
        except ValueError as wrong:
            raise Discrepancy(str(wrong), permanent=True, cause=causes.UNSUITABLE) from None
        camera = spec.hand_camera
        self._block, self._tip = block, spec.finger_shape.tip
        self._hand_T_camera = known_camera(camera, mount_of(spec, camera, arm)).hand_T_camera
        width = (block[0] + OPENING_CLEARANCE_M) / 2.0
        self._open = arm.with_others({"left_finger": width, "right_finger": width})

    def stops(self, landmarks: Sequence[LevelPose]) -> StopPlacer:
        """Return a search for poses of the base from which the camera sees one of the given landmarks."""
        return StopPlacer(self.placer, [partial(self._sight, mark) for mark in landmarks])

    def goal(self, place: LevelPose) -> Goal:
        """Return the hand poses for approaching a block from above, and those that hold the camera above the
        block.

        Args:
            place: pose of the block, on the map.
        """
        grip = pointing_down(place.floor, place.height_m + self._block[2] - GRIP_DEPTH_M + self._tip)
        work = tool_path([transform((0.0, 0.0, up)) @ grip for up in (WAIT_HEIGHT_M, WAIT_HEIGHT_M / 2, 0.0)])
        level = place.floor.theta
        return Goal(work, (self._looking(place.floor, place.height_m + self._block[2], level),))

    def touches(self, base: FloatArray, place: LevelPose, around: Sequence[Box], held: bool) -> str:
        """Describe why the arm cannot work at a block, by reach or by contact of arm or held block.

        The text is empty if the hand reaches the block from above without contact.

        Args:
            base: (3,) map_T_base: x, y in [m], heading in [rad].
            place: place of the block, on the map.
            around: surrounding bodies, posed on the map.
            held: True if the hand carries the block and puts it down there.
        """
        path, stand = self.goal(place).work, Pose2(*base.tolist()).lift()
        try:
            angles = self.placer.joints(base, path)
        except Untrackable as error:
            return error.why
        length, width, height = self._block
        middle = transform((self._tip - GRIP_DEPTH_M + height / 2, 0.0, 0.0))
        body = Box(middle, (height, length, width), HELD_NAME) if held else None
        free = CollisionModel(self._open, around, None, stand, STAND_MARGIN_M)
        loaded = CollisionModel(self._open, around, body, stand, STAND_MARGIN_M)
        for number, q in enumerate(angles):
            model = loaded if number < len(angles) - 1 else free  # in the end it touches what carries it
            if model.in_collision(q):
                return "is reached only with the arm touching something"
        return ""

    def body(self, place: LevelPose, name: str) -> Box:
        """Return the body of a block at a pose on the map, as a box with the given name for checks of
        contact.
        """
        return place.body(self._block, name)

    def _sight(self, mark: LevelPose, heading: float) -> ToolPath:
        """Return two poses of the hand with the camera above a landmark, turned by the base's `heading` in
        [rad].
        """
        return self._looking(mark.floor, mark.height_m, heading)

    def _looking(self, floor: Pose2, height: float, heading: float) -> ToolPath:
        """Return two poses of the hand, one above the other, with the camera straight above a place.

        Args:
            floor: x and y of the place on the map.
            height: height of the place above the floor, in [m].
            heading: direction of the picture, in [rad].
        """
        view = pointing_down(Pose2(0.0, 0.0, heading), 0.0)
        view[:3, 3] = (floor.x, floor.y, height + VIEW_DISTANCE_M) - (view @ self._hand_T_camera)[:3, 3]
        return tool_path([view, transform((0.0, 0.0, HEIGHT_STEP_M)) @ view])
