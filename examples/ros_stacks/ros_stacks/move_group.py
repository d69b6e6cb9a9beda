"""MOVE_GROUP: bring the arm to a posture on a path that MoveIt plans."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from handcart import ActionPrimitive, Arm, CauseKind, Discrepancy, causes
from handcart.files.errors import HandcartError
from handcart.primitives.motions.arm_motion import follow

from .stacks import ENDED_STATES, ArmPlanner, GoalState, Waypoints

MOVEIT_FAILED = CauseKind("moveit_failed", "MoveIt finds no path, or one that cannot be followed.")
MAX_START_GAP_RAD = 0.02
"""[rad] or [m] between the arm's command and the path's first point."""
MAX_OFF_RAD = 0.02


def connect_moveit() -> ArmPlanner:
    """Return the real MoveIt."""
    from .moveit import MoveIt

    return MoveIt()


class MoveGroup(ActionPrimitive):
    """Bring the arm to a named posture on a path that MoveIt plans around its planning scene.

    MoveIt plans only (`plan_only`): `ExecuteTrajectory` would drive the controllers past the framework, and
    nobody could stop, time or undo the motion. The path is timed and followed here, each joint compared with
    its command; a Discrepancy plays it backwards.
    """

    posture: str
    """Name of a posture in the robot's file."""
    group: str = "arm"
    """Planning group of MoveIt's SRDF."""
    limit_s: Annotated[float, Field(gt=0.0)] = 30.0
    """Time in which a path has to be found."""

    needs: ClassVar = (Arm,)
    connect: ClassVar[Callable[[], ArmPlanner]] = staticmethod(connect_moveit)
    """Connects to MoveIt; tests put their own in its place."""

    def unmet_precondition(self, robot, model):
        known = robot.spec.arm.postures
        return "" if self.posture in known else f"unknown posture {self.posture!r}; known: {', '.join(known)}"

    def motion(self, robot, model):
        goal = np.array(robot.spec.posture(self.posture))
        try:
            moveit = yield from robot.compute(type(self).connect)
        except HandcartError as missing:
            raise Discrepancy(str(missing), permanent=True, cause=causes.UNSUITABLE) from None
        try:
            moveit.plan(self.group, robot.spec.arm.joints, goal.tolist())
            yield from self._await_path(robot, moveit)
            path = checked_path(robot, moveit.path(), goal)
        finally:
            moveit.close()
        yield from follow(robot, path)

    def _await_path(self, robot, moveit):
        end = robot.time + self.limit_s
        while (state := moveit.state()) not in ENDED_STATES:
            if robot.time > end:
                raise Discrepancy(f"MoveIt has no path after {self.limit_s:g} s", cause=causes.TIME_OUT)
            yield
        if state is not GoalState.SUCCEEDED:
            raise Discrepancy(f"MoveIt: {state.value}: {moveit.why()}", cause=MOVEIT_FAILED)

    def effect(self, robot, model):
        """Measure the joints at rest."""
        off = float(np.abs(robot.arm.joints() - robot.spec.posture(self.posture)).max())
        self.found(joints_off_rad=round(off, 4))
        return off <= MAX_OFF_RAD
        yield


def checked_path(robot, found: Waypoints, goal):
    """Return a path (m, n) in the order of the robot's joints.

    Raises:
        Discrepancy: it is for other joints, begins elsewhere, ends elsewhere, or leaves the limits.
    """
    joints = robot.spec.arm.joints
    if set(found.names) != set(joints):
        words = f"MoveIt's path is for {', '.join(found.names)}; needed: {', '.join(joints)}"
        raise Discrepancy(words, permanent=True, cause=MOVEIT_FAILED)
    path = np.array(found.positions, dtype=np.float64).reshape(-1, len(joints))
    path = path[:, [list(found.names).index(name) for name in joints]]
    if len(path) < 2 or not np.isfinite(path).all():
        raise Discrepancy(f"MoveIt's path has {len(path)} finite points", cause=MOVEIT_FAILED)
    for what, point, wanted in (("begins", path[0], robot.arm.command()), ("ends", path[-1], goal)):
        if (gap := float(np.abs(point - wanted).max())) > MAX_START_GAP_RAD:
            words = f"MoveIt's path {what} {gap:.3g} rad or m off; allowed: {MAX_START_GAP_RAD:g}"
            raise Discrepancy(words, cause=MOVEIT_FAILED)
    model = robot.spec.arm_model()
    if (beyond := float(np.abs(path - np.array([model.clipped(item) for item in path])).max())) > 1e-6:
        raise Discrepancy(f"MoveIt's path leaves a limit by {beyond:.3g} rad or m", cause=MOVEIT_FAILED)
    path[0], path[-1] = robot.arm.command(), goal
    return path
