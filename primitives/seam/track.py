"""TRACK: follow a part of the seam with the tool, from a base at rest or driving along."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.driving import (
    WATCH_HORIZON_M,
    FieldObstacleMonitor,
    ObstacleMonitor,
    make_monitor,
)
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import follow, move_to_joints, move_to_posture
from handcart.primitives.motions.felt_force import FeltForce
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.primitives.seam import seam_causes
from handcart.primitives.seam.seam import Seam
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.alongside import level_with, seen_from
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.manipulation.tracking.tracking_limits import ArmLoad
from handcart.robotics.manipulation.tracking.tracking_time import (
    TimedTracking,
    TrackingLimits,
    time_evenly,
    time_tracking,
)
from handcart.robotics.numerics.arrays import FloatArray

from .divide import seam_of
from .driven_base import START_ACCELERATION_SHARE, DrivenBase, way_from_here
from .seam_placer import placer_of
from .seam_work import SeamPart

POSITIONING_AVERAGING_S = 2.0  # at rest in which the positioning is averaged
LEAD_DISTANCE_M = 0.06  # before the seam where the tool comes from
MOST_OFF = 0.003  # [m] of the tool from where it should be
TOOL_CONTACT_FORCE_N = 15.0
TOOL_SIGMAS = 3.0  # sigma
TOOL_REACH_M = 1.2  # from the base to the tool, about


class _Plan(NamedTuple):
    """Planned motion for a part of the seam."""

    timed: TimedTracking
    tools: ToolPath
    """Path of the tool, one point each period."""
    way_in: FloatArray
    """(m, n) joints of the arm on the way to the first point, in [rad] or [m]."""


class Track(ActionPrimitive):
    """Follow the next part of the seam with the tool, from a base at rest or driving.

    The part and the planned poses of the base are those found by the primitive DIVIDE.

    Joint angles are computed for the measured pose, because a base never stops exactly at its planned pose.
    If the base is at rest, only the errors of localization and arm remain. If the base drives, the angles are
    computed again in each period, for the pose that the base has at the end of the period.
    """

    speed_m_s: Annotated[float, Field(gt=0.0, le=2.0)] | None = None
    """Speed of the tool (default: as in the robot's file)."""

    needs: ClassVar = (Arm, Positioning)
    reads: ClassVar = ("map", "seam", "work_piece")
    writes: ClassVar = ("seam_work", "obstacles")

    _part: ToolPath | None = PrivateAttr(default=None)
    _at: int | None = PrivateAttr(default=None)
    _driven: DrivenBase | None = PrivateAttr(default=None)
    _monitor: ObstacleMonitor | FieldObstacleMonitor | None = PrivateAttr(default=None)

    @property
    def tracking(self) -> ToolPath | None:
        """Part of the seam that the tool is following at present; None before and after this motion."""
        return self._part if self._at is not None else None

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        known = model.of(Seam)
        seam, work = seam_of(model), known.seam_work
        if work.next is None:
            raise Discrepancy("the seam isn't divided", permanent=True, cause=causes.NOT_KNOWN)
        if work.next.empty:  # all of it is tracked
            return
        yield from robot.wait(POSITIONING_AVERAGING_S)
        _check_known(robot)
        part = seam.part(work.next.first, work.next.last)
        placer = placer_of(robot.spec, self.speed_m_s)
        around = _around(robot, model)
        start = way_from_here(robot, work.next.place, work.next.pose) if work.next.end else None
        try:
            plan = yield from robot.compute(self._planned, robot, placer, part, start, takes=1.0)
        except Untrackable as error:
            known.seam_work = work._replace(next=None, after=(), avoided=(*work.avoided, robot.pose))
            raise Discrepancy(
                _words(work.next, error), cause=seam_causes.UNTRACKABLE
            ) from None  # not for good: DIVIDE avoids this place
        yield from move_to_joints(robot, plan.way_in[0], None, around)
        yield from follow(robot, plan.way_in)
        if start is not None:
            self._driven = DrivenBase(robot, placer.follower, plan.tools, start, plan.way_in[-1])
            self._monitor = make_monitor(robot, model)
        yield from self._on_seam(robot, part, plan)
        yield from _away(robot, placer)
        yield from move_to_posture(robot, "home", None, _around(robot, model))
        self.found(length_m=round(part.length, 3), part_score_m=round(work.next.score, 4))
        known.seam_work = work.done()

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Look for an obstacle in the way of the driving base.

        The obstacle is recorded in the model, so that the primitive DIVIDE plans the base's next poses
        around it.

        Raises:
            Discrepancy: an obstacle is in the way.
        """
        if self._at is None or self._driven is None or self._monitor is None:
            return
        sensed = self._monitor.unexpected(robot)
        found = self._monitor.obstacle(self._driven.ahead(self._at), sensed)
        if found is not None:
            model.obstacles = np.vstack([model.obstacles, self._monitor.kept(sensed, found[1])])
            x, y = found[1]
            raise Discrepancy(
                f"an obstacle is on the base's route along the seam, at ({x:.2f}, {y:.2f}) m",
                measured=Measured("RangeSensor", "free way ahead", found[0], WATCH_HORIZON_M, "m"),
                cause=causes.BLOCKED,
            )

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Drive the base back with the arm folded if it drove along the seam; otherwise the tool would touch
        the work piece.
        """
        self._at = None
        if self._driven is None:
            yield from retrace(robot, start, trace)
            return
        yield from _away(robot, placer_of(robot.spec, self.speed_m_s))
        yield from move_to_joints(robot, start.joint_command, None, _around(robot, model))
        folded = Trace(robot)
        folded.moments = [moment._replace(joints=start.joint_command) for moment in trace.moments]
        yield from retrace(robot, start, folded)

    def _planned(self, robot: Robot, placer: Placer, part: ToolPath, start: Pose2 | None) -> _Plan:
        """Return the plan for a base that drives on from `start`, map_T_base, or stays where it is."""
        limits = self._limits(robot, placer.arm)
        if start is None:
            angles = placer.joints(np.array(robot.pose), part)
            timed = time_tracking(placer.arm, part, angles, limits, robot.period)
        else:
            seen = seen_from(level_with(start, part.points), part)
            angles = placer.joints(np.zeros(3), seen)
            ramp = START_ACCELERATION_SHARE * robot.drive_limits.acceleration
            timed = time_evenly(placer.arm, seen, angles, limits, ramp, robot.period)
        way_in = placer.follower.joints(_lead(part.poses[0]), robot.pose.lift(), angles[0])[::-1]
        return _Plan(timed, part.at(timed.lengths), way_in)

    def _limits(self, robot: Robot, model: ArmModel) -> TrackingLimits:
        arm, tool = robot.spec.arm, robot.spec.tool
        assert arm is not None and tool is not None, "checked by `placer_of`"
        hard = robot.spec.joint_accelerations()
        speed = self.speed_m_s or tool.speed_m_s
        return TrackingLimits(speed, hard, ArmLoad(model).torque, tool.force_n)

    def _on_seam(self, robot: Robot, part: ToolPath, plan: _Plan) -> Periods:
        self._part, worst, felt = part, 0.0, FeltForce(robot)
        for self._at, (q, point) in enumerate(zip(plan.timed.set_points, plan.tools.points, strict=True)):
            robot.arm.move(q if self._driven is None else self._driven.joints(self._at))
            yield
            tip = (robot.pose.lift() @ robot.base_T("hand"))[:3, 3]
            worst = max(worst, float(np.linalg.norm(tip - point)))  # joints of NaN: TrackingErrorMonitor
            self.found(off_mm=round(1e3 * worst, 3))
            if worst > MOST_OFF:
                off = Measured("Arm", "tool off the seam", 1e3 * worst, 1e3 * MOST_OFF, "mm")
                raise Discrepancy("the tool leaves the seam", measured=off, cause=seam_causes.OFF_SEAM)
            read = felt.read()
            force = 0.0 if read is None else float(np.linalg.norm(read))
            if force > TOOL_CONTACT_FORCE_N:
                raise Discrepancy(
                    "the tool touches something",
                    measured=Measured("Arm", "force", force, TOOL_CONTACT_FORCE_N, "N"),
                    cause=seam_causes.TOOL_CONTACT,
                )
            _check_known(robot)
        self._at = None


def _away(robot: Robot, placer: Placer) -> Periods:
    """Move the tool straight back along its axis, if the arm can."""
    hand = robot.pose.lift() @ robot.arm_model.forward(robot.arm.command(), "hand")
    try:
        way_out = placer.follower.joints(_lead(hand), robot.pose.lift(), robot.arm.command())
    except Untrackable:
        return
    yield from follow(robot, way_out)


def _check_known(robot: Robot) -> None:
    """Raise `Discrepancy` if the pose of the base is not known well enough."""
    x, y, turn = np.sqrt(np.diag(robot.localization.covariance)).tolist()
    off = TOOL_SIGMAS * math.hypot(x, y, TOOL_REACH_M * turn)
    if exceeds(off, MOST_OFF):
        measured = Measured(
            "Positioning", f"{TOOL_SIGMAS:g} sigma of the tool", 1e3 * off, 1e3 * MOST_OFF, "mm"
        )
        raise Discrepancy(
            "the pose of the base isn't known exactly enough", measured=measured, cause=causes.UNDETERMINED
        )


def _lead(pose: FloatArray) -> ToolPath:
    """Return the straight path of the tool from a pose (4, 4) back along the tool's axis."""
    return tool_path([pose @ transform((-away, 0.0, 0.0)) for away in np.linspace(0.0, LEAD_DISTANCE_M, 7)])


def _around(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """Return the work piece, posed in the base frame."""
    work = model.of(Seam)
    if work.work_piece is None:
        return ()
    base_T_map = robot.pose.inverse().lift()
    boxes = (item.box for item in work.work_piece.boxes)
    return tuple(box.seen_from(base_T_map) for box in boxes)


def _words(part: SeamPart, error: Untrackable) -> str:
    where = "" if "where the base stands" in error.why else ", where the base stands"
    return f"line {part.first + error.index + 2} of the seam {error.why}{where}"
