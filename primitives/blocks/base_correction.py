"""Corrections of the turn and tilt of the base between its last fixation and the placing of a block."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from typing import ClassVar, Literal

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.blocks import Blocks, Fixed
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.manipulation.suspension.suspension_model import base_motion
from handcart.robotics.numerics.arrays import FloatArray

from .base_lean import felt_beside, unmodelled_leans
from .base_turn import BaseTurn, fused, turn_by_gyros, turn_by_model
from .building_site import standing
from .fixate import landmark_of
from .fixating import upright

Method = Literal["fix_once", "model", "imu", "fix_again", "fix_again_model", "fix_again_imu", "servo"]
View = Generator[None, None, Fixed]


class FixOnce:
    """Base class of corrections of the base's turn and tilt before placing a block; this class corrects
    nothing.

    A robot on wheels with suspension turns and tilts as its loaded arm moves (Hatano et al. 2000). A fixation
    is a measurement of the base's pose at a landmark. The base moves between the last fixation and the
    placing. One instance serves one attempt.
    """

    needs_imu: ClassVar[bool] = False
    """True if the robot needs inertial sensors."""
    views_landmark: ClassVar[bool] = False
    """True if the landmark of the fixation is viewed again before placing, with the block in the hand."""
    views_goal: ClassVar[bool] = False
    """True if a landmark beside the goal is viewed, and the goal is found relative to it."""
    looks: ClassVar[int] = 1
    """Minimum number of views over a landmark; after each move the arm has another error."""

    def take_view(
        self, robot: Robot, before: Fixed | None, now: Fixed, swings: int
    ) -> Generator[None, None, Fixed]:
        """Return the base's pose (fixation) to use after a further view of a landmark.

        Args:
            robot: robot with its hand over the landmark.
            before: fixation before this view; None if there was none.
            now: fixation by this view.
            swings: number of swings of the loaded arm between the two fixations; each turns the base.
        """
        return now
        yield

    def measure_over_goal(self, robot: Robot) -> Generator[None, None, bool]:
        """Measure how the base has moved while the hand holds the block over its goal, if the correction
        needs that.

        Return True if the goal has to be computed again in the base frame, because a motion was measured.
        """
        return False
        yield

    def base_T_block(self, robot: Robot, model: ModelView, goal: LevelPose, swings_to_come: int) -> Transform:
        """Return the pose base_T_block (4, 4) at which a block has to be placed, given a goal on the map.

        Args:
            robot: robot that places the block.
            model: world model with the last fixation (pose of the base measured at a landmark).
            goal: pose of the placed block on the map.
            swings_to_come: number of swings of the loaded arm until the block is placed; each turns the base
                a little.

        Raises:
            Discrepancy: no landmark was seen from the present pose of the base.
        """
        fixation(model)
        return np.asarray(inverse(standing(robot, model).lift()) @ goal.pose)


class ByModel(FixOnce):
    """Correction of the base's turn and tilt by a prediction of the suspension's model.

    The model is that of Hatano et al. (2000), eq. 12.
    """

    def __init__(self) -> None:
        self._leans: tuple[Transform, Transform] = (np.eye(4), np.eye(4))
        """Tilts of the base beyond the model at the fixation and now, as motions (4, 4)."""

    @override
    def base_T_block(self, robot: Robot, model: ModelView, goal: LevelPose, swings_to_come: int) -> Transform:
        fixed, known = fixation(model), robot.spec.suspension.model
        height = landmark_of(model, fixed.landmark).height_m
        then, now = self._leans
        turn = Pose2(0.0, 0.0, self.turned(robot, fixed, swings_to_come))
        turned = upright(fixed, known, height, then).compose(turn).lift() @ now
        return known.corrected(inverse(turned) @ goal.pose, np.eye(4), 0)

    def turned(self, robot: Robot, fixed: Fixed, swings_to_come: int) -> float:
        """Return the base's yaw from a fixation until a block is placed, in [rad], positive to the left.

        Args:
            robot: the robot.
            fixed: the fixation (pose of the base measured at a landmark).
            swings_to_come: number of swings of the loaded arm until the block is placed; each turns the base
                a little.
        """
        return turn_by_model(robot, fixed.swings + swings_to_come).yaw


class ByImu(FixOnce):
    """Correction for the base's turn and tilt, measured by its IMU while the block is held over its goal."""

    needs_imu: ClassVar = True

    @override
    def measure_over_goal(self, robot: Robot) -> Generator[None, None, bool]:
        yield from settle(robot)
        return True

    @override
    def base_T_block(self, robot: Robot, model: ModelView, goal: LevelPose, swings_to_come: int) -> Transform:
        uncorrected = super().base_T_block(robot, model, goal, swings_to_come)
        return uncorrected if swings_to_come else inverse(_felt(robot, fixation(model))) @ uncorrected


class FixAgain(FixOnce):
    """Correction of the base's turn and tilt by measuring its pose again at the landmark before placing.

    The hand holds the block during this second measurement, which replaces the first.
    """

    views_landmark: ClassVar = True


class FixAgainModel(ByModel):
    """Correction of the base's turn and tilt by a second view of the landmark and the suspension's model.

    The poses of the base from both views are fused. The model predicts turn and tilt after the second view.
    """

    views_landmark: ClassVar = True

    @override
    def take_view(
        self, robot: Robot, before: Fixed | None, now: Fixed, swings: int
    ) -> Generator[None, None, Fixed]:
        return now if before is None else fused(before, self._turn_to_view(robot, before, now, swings), now)
        yield

    def _turn_to_view(self, robot: Robot, before: Fixed, now: Fixed, swings: int) -> BaseTurn:
        return turn_by_model(robot, before.swings + swings)


class FixAgainImu(FixAgainModel):
    """Correction of the base's turn and tilt by two views of a landmark and by the inertial sensors.

    The poses of the base from both views are fused. After the second view, the gyros measure the base's turn;
    the accelerometers measure the tilt that the suspension's model does not predict.
    """

    needs_imu: ClassVar = True

    def __init__(self) -> None:
        super().__init__()
        self._felt_then: FloatArray = np.zeros(2)
        """Roll and pitch (2,) beyond the model at the view of the landmark, in [rad]."""

    @override
    def take_view(
        self, robot: Robot, before: Fixed | None, now: Fixed, swings: int
    ) -> Generator[None, None, Fixed]:
        self._felt_then = yield from felt_beside(robot)
        return (yield from super().take_view(robot, before, now, swings))

    @override
    def measure_over_goal(self, robot: Robot) -> Generator[None, None, bool]:
        yield from settle(robot)
        self._leans = unmodelled_leans(robot, self._felt_then, (yield from felt_beside(robot)))
        return True

    @override
    def turned(self, robot: Robot, fixed: Fixed, swings_to_come: int) -> float:
        return turn_by_gyros(robot, fixed).yaw + turn_by_model(robot, swings_to_come).yaw

    @override
    def _turn_to_view(self, robot: Robot, before: Fixed, now: Fixed, swings: int) -> BaseTurn:
        return turn_by_gyros(robot, before, now)


class Servo(FixOnce):
    """Correction of the base's motion before a placing, by viewing a landmark next to the goal.

    The goal's pose follows from that of this landmark, which is viewed with the block in the hand.
    """

    views_goal: ClassVar = True
    looks: ClassVar = 2


class OnRobot(FixOnce):
    """Placing of a block on the robot's own table, which turns and tilts with the base, so that the base's
    motion needs no correction.
    """

    @override
    def base_T_block(self, robot: Robot, model: ModelView, goal: LevelPose, swings_to_come: int) -> Transform:
        return goal.pose


METHOD_CORRECTIONS: Mapping[Method, type[FixOnce]] = {
    "fix_once": FixOnce,
    "model": ByModel,
    "imu": ByImu,
    "fix_again": FixAgain,
    "fix_again_model": FixAgainModel,
    "fix_again_imu": FixAgainImu,
    "servo": Servo,
}


def fixation(model: ModelView) -> Fixed:
    """Return the pose of the base as last measured at a landmark (the last fixation).

    Raises:
        Discrepancy: no landmark was seen since the base last moved.
    """
    fixed = model.of(Blocks).fixed
    if fixed is None:
        raise Discrepancy("no landmark was seen from here", permanent=True, cause=causes.NOT_KNOWN)
    return fixed


def _felt(robot: Robot, fixed: Fixed) -> Transform:
    """Return fixed_T_base (4, 4) by the inertial sensors: turn and tilt since the fixation."""
    roll, pitch = robot.attitude.tilt
    before = fixed.attitude
    yaw = robot.attitude.yaw - before[2]
    return base_motion(yaw, roll - before[0], pitch - before[1], robot.spec.suspension.pivot_m)
