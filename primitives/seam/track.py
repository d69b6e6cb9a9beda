"""TRACK: follow a part of the seam with the tool, from where the base stands."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.discrepancy import Discrepancy, Measured
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import follow, move_to_joints, move_to_posture
from handcart.primitives.seam.seam import Seam
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.manipulation.placement.untrackable import Untrackable
from handcart.robotics.manipulation.tracking.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.tracking.tracking_limits import ArmLoad
from handcart.robotics.manipulation.tracking.tracking_time import TimedTracking, TrackingLimits, time_tracking

from .divide import seam_of
from .seam_placer import placer_of
from .seam_work import SeamPart

LOOK = 2.0  # [s] at rest in which the positioning is averaged
AWAY = 0.06  # [m] before the seam where the tool comes from
MOST_OFF = 0.003  # [m] of the tool from where it should be
CONTACT = 15.0  # [N]
SURE = 3.0  # sigma
REACH = 1.2  # [m] from the base to the tool, about

Floats = NDArray[np.float64]


class Track(ActionPrimitive):
    """Follow the next part of the seam with the tool while the base stands.

    The base never stops where it was planned: joint angles are found for where the positioning says that it
    stands. Then the arm is as exact as positioning and arm are, and a moving base's errors don't count.
    """

    speed_m_s: Annotated[float, Field(gt=0.0, le=2.0)] | None = None
    """Of the tool; left out: the tool's, by the robot's file."""

    needs: ClassVar = (Arm, Positioning)
    reads: ClassVar = ("seam", "work_piece")
    writes: ClassVar = ("seam_work",)

    _part: ToolPath | None = PrivateAttr(default=None)
    _at: int | None = PrivateAttr(default=None)

    @property
    def tracking(self) -> ToolPath | None:
        """The part that the tool is on in this period; None before and after."""
        return self._part if self._at is not None else None

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        known = model.of(Seam)
        seam, work = seam_of(model), known.seam_work
        if work.next is None:
            raise Discrepancy("the seam isn't divided", permanent=True)
        if work.next.empty:  # all of it is tracked
            return
        yield from robot.wait(LOOK)
        _check_known(robot)
        part = seam.part(work.next.first, work.next.last)
        placer = placer_of(robot.spec, self.speed_m_s)
        around = _around(robot, model)
        try:
            timed, way_in, way_out = yield from robot.compute(self._planned, robot, placer, part, takes=1.0)
        except Untrackable as error:
            known.seam_work = work._replace(next=None, after=(), avoided=(*work.avoided, robot.pose))
            raise Discrepancy(_words(work.next, error)) from None  # not for good: DIVIDE avoids this place
        yield from move_to_joints(robot, way_in[0], None, around)
        yield from follow(robot, way_in)
        yield from self._on_seam(robot, part, timed)
        yield from follow(robot, way_out)
        yield from move_to_posture(robot, "home", None, around)
        self.found(length_m=round(part.length, 3), part_score_m=round(work.next.score, 4))
        known.seam_work = work.done()

    def _planned(self, robot: Robot, placer: Placer, part: ToolPath) -> tuple[TimedTracking, Floats, Floats]:
        """Set-points along the part, and joint angles (m, n) that lead to its start and away from its end."""
        stand = np.array(robot.pose)
        angles = placer.joints(stand, part)
        timed = time_tracking(placer.arm, part, angles, self._limits(robot, placer.arm), robot.period)
        leave, last = placer.follower.joints, len(part.points) - 1
        way_in = leave(_lead(part, 0), robot.pose.lift(), angles[0])[::-1]
        return timed, way_in, leave(_lead(part, last), robot.pose.lift(), angles[-1])

    def _limits(self, robot: Robot, model: ArmModel) -> TrackingLimits:
        arm, tool = robot.spec.arm, robot.spec.tool
        assert arm is not None and tool is not None, "checked by `placer_of`"
        hard = robot.spec.joint_accelerations()
        speed = self.speed_m_s or tool.speed_m_s
        return TrackingLimits(speed, hard, ArmLoad(model).torque, tool.force_n)

    def _on_seam(self, robot: Robot, part: ToolPath, timed: TimedTracking) -> Periods:
        self._part, worst = part, 0.0
        should = np.array([np.interp(timed.lengths, part.lengths, axis) for axis in part.points.T]).T
        for self._at, (q, point) in enumerate(zip(timed.set_points, should, strict=True)):
            robot.arm.move(q)
            yield
            tip = (robot.pose.lift() @ robot.base_T("hand"))[:3, 3]
            worst = max(worst, float(np.linalg.norm(tip - point)))
            self.found(off_mm=round(1e3 * worst, 3))
            if worst > MOST_OFF:
                off = Measured("Arm", "tool off the seam", 1e3 * worst, 1e3 * MOST_OFF, "mm")
                raise Discrepancy("the tool leaves the seam", measured=off)
            force = float(np.linalg.norm(robot.arm.hand_force()))
            if force > CONTACT:
                raise Discrepancy(
                    "the tool touches something", measured=Measured("Arm", "force", force, CONTACT, "N")
                )
        self._at = None


def _check_known(robot: Robot) -> None:
    """Raise `Discrepancy` where the positioning didn't tell well enough where the base stands."""
    x, y, turn = np.sqrt(np.diag(robot.localization.covariance)).tolist()
    off = SURE * math.hypot(x, y, REACH * turn)
    if off > MOST_OFF:
        measured = Measured("Positioning", f"{SURE:g} sigma of the tool", 1e3 * off, 1e3 * MOST_OFF, "mm")
        raise Discrepancy("it isn't known exactly enough where the base stands", measured=measured)


def _lead(part: ToolPath, index: int) -> ToolPath:
    """From a point of the part straight back along the tool."""
    pose = part.poses[index]
    return tool_path([pose @ transform((-away, 0.0, 0.0)) for away in np.linspace(0.0, AWAY, 7)])


def _around(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """The work piece, posed in the base frame."""
    work = model.of(Seam)
    if work.work_piece is None:
        return ()
    base_T_map = robot.pose.inverse().lift()
    boxes = (each.box for each in work.work_piece.boxes)
    return tuple(Box(base_T_map @ box.pose, box.size, box.name) for box in boxes)


def _words(part: SeamPart, error: Untrackable) -> str:
    where = "" if "where the base stands" in error.why else ", where the base stands"
    return f"line {part.first + error.index + 2} of the seam {error.why}{where}"
