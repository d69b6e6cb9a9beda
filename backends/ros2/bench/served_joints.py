"""Controllers of a simulated robot that take goals, as those of ros2_control do."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.ros2.wire.goals import GoalStage, ServedGoal
from handcart.backends.ros2.wire.messages import GRIPPER_ACTION, TRAJECTORY_ACTION
from handcart.backends.ros2.wire.ros_link import Link

from .bench_faults import BenchFaults

SUCCESSFUL, INVALID_GOAL, GOAL_TOLERANCE_VIOLATED = 0, -1, -5
GOAL_TOLERANCE = 0.05
"""Largest deviation of a joint from the end of a trajectory, in [rad] or [m]."""
GOAL_TIME_S = 1.0
"""Time after the end of a trajectory within which its joints have to arrive, in [s]."""
PREEMPTED = "Current goal cancelled due to new incoming action."


class JointPlan(NamedTuple):
    """Trajectory of joints whose positions are interpolated linearly over time between its points."""

    begun_s: float
    """Time of the bench at which the plan begins, in [s]."""
    names: tuple[str, ...]
    times_s: tuple[float, ...]
    """Times (n,) after the beginning, in [s]; the first is 0."""
    positions: tuple[tuple[float, ...], ...]
    """Positions of the joints `names` at each of these n times, in [rad] or [m]."""

    def at(self, now_s: float) -> dict[str, float]:
        """Return the planned positions at a time of the bench in [s], in [rad] or [m] by the joint's name."""
        rows, after = np.array(self.positions), now_s - self.begun_s
        return {
            name: float(np.interp(after, self.times_s, rows[:, place]))
            for place, name in enumerate(self.names)
        }

    @property
    def end_s(self) -> float:
        """Time of the bench at which the trajectory ends, in [s]."""
        return self.begun_s + self.times_s[-1]


class ServedJoints:
    """Simulated joint controller with an action server.

    The joints follow the trajectory of the last accepted goal, and then hold its last positions.
    """

    STATE: ClassVar[Kinds] = {"_plan": JointPlan | None}

    def __init__(self, link: Link, kind: str, name: str, joints: Sequence[str], faults: BenchFaults) -> None:
        """Offer an action.

        Args:
            link: the drivers' node.
            kind: type of the action.
            name: name of the action.
            joints: names in ROS of the joints that it moves.
            faults: planned faults of the action.
        """
        self.name, self._kind, self._joints, self._faults = name, kind, tuple(joints), faults
        self._goal: ServedGoal | None = None
        self._asked: ServedGoal | None = None
        self._plan: JointPlan | None = None
        self._now = 0.0
        link.serve_action(kind, name, self._accepts, self._take)

    def wanted(self, now_s: float, period: float, measured: Mapping[str, float]) -> Mapping[str, float]:
        """Return the commanded positions at the end of a period, in [rad] or [m] by the joint's name.

        The result is empty before the first goal of the served ROS action (motion of these joints).

        Args:
            now_s: time of the bench at the beginning of the period, in [s].
            period: length of the period, in [s].
            measured: current positions of the joints, in [rad] or [m] by name.
        """
        self._now = now_s
        if self._asked is not None:
            self._begin(self._asked, measured)
            self._asked = None
        if self._goal is not None and self._goal.is_cancel_asked:
            self._plan = JointPlan(now_s, self._joints, (0.0,), (tuple(measured[n] for n in self._joints),))
            self._end(GoalStage.CANCELED, SUCCESSFUL, "")
        return {} if self._plan is None else self._plan.at(now_s + period)

    def settle(self, now_s: float, measured: Mapping[str, float], presses: bool) -> None:
        """End the goal of the ROS action if the joints have reached it, if a joint is still off more than
        `GOAL_TIME_S` after the planned end, if an object stops the fingers, or for a simulated fault.

        Args:
            now_s: time of the bench, in [s].
            measured: current positions of the joints, in [rad] or [m] by name.
            presses: True if fingers press on something.
        """
        goal, plan = self._goal, self._plan
        if goal is None or plan is None:
            return
        if self._faults.is_due("aborts", self.name, now_s):
            self._end(GoalStage.ABORTED, GOAL_TOLERANCE_VIOLATED, "planned")
        elif self._faults.is_due("cancels", self.name, now_s):
            self._end(GoalStage.CANCELED, SUCCESSFUL, "")
        elif now_s >= plan.end_s - 1e-9:
            wanted = plan.at(plan.end_s)
            off = max(abs(measured[name] - wanted[name]) for name in plan.names)
            if off <= GOAL_TOLERANCE and not (self._kind == GRIPPER_ACTION and off > 1e-3):
                self._end(GoalStage.SUCCEEDED, SUCCESSFUL, "")
            elif self._kind == GRIPPER_ACTION:
                if presses:
                    self._end(GoalStage.ABORTED, SUCCESSFUL, "", stalled=True)
            elif now_s > plan.end_s + GOAL_TIME_S:
                self._end(GoalStage.ABORTED, GOAL_TOLERANCE_VIOLATED, f"a joint is off by {off:.3g}")

    def _accepts(self, request: Any) -> bool | None:
        """Return whether a goal is one of this controller: its joints, finite, in order of time."""
        if self._faults.is_due("unanswered", self.name, self._now):
            return None
        if self._faults.is_due("rejects", self.name, self._now):
            return False
        if self._kind == GRIPPER_ACTION:
            return math.isfinite(request.command.position)
        trajectory = request.trajectory
        times = [_seconds(point.time_from_start) for point in trajectory.points]
        rows = [point.positions for point in trajectory.points]
        return (
            sorted(trajectory.joint_names) == sorted(self._joints)
            and bool(rows)
            and all(a < b for a, b in zip([-1e-9, *times], times, strict=False))
            and all(len(row) == len(self._joints) and all(map(math.isfinite, row)) for row in rows)
        )

    def _take(self, goal: ServedGoal) -> None:
        for before in (self._goal, self._asked):
            if before is not None:
                self._end(GoalStage.ABORTED, INVALID_GOAL, PREEMPTED, goal=before)
        self._goal, self._asked = None, goal

    def _begin(self, goal: ServedGoal, measured: Mapping[str, float]) -> None:
        """Plan the way from the measured positions to the goal; fingers go as fast as they can."""
        self._goal = goal
        if self._kind == TRAJECTORY_ACTION:
            trajectory = goal.request.trajectory
            names = tuple(trajectory.joint_names)
            times = tuple(_seconds(point.time_from_start) for point in trajectory.points)
            rows = tuple(tuple(map(float, point.positions)) for point in trajectory.points)
        else:
            names, times = self._joints, (0.0,)
            rows = (tuple(float(goal.request.command.position) for _ in names),)
        start = tuple(measured[name] for name in names)
        before = ((0.0,), (start,)) if times[0] > 0.0 else ((), ())
        self._plan = JointPlan(self._now, names, (*before[0], *times), (*before[1], *rows))

    def _end(
        self, stage: GoalStage, code: int, words: str, stalled: bool = False, goal: ServedGoal | None = None
    ) -> None:
        over = goal or self._goal
        if over is None:
            return
        result = over.new_result()
        if self._kind == GRIPPER_ACTION:
            result.stalled, result.reached_goal = stalled, stage is GoalStage.SUCCEEDED
        else:
            result.error_code, result.error_string = code, words
        over.end(stage, result)
        if over is self._goal:
            self._goal = None


def _seconds(duration: Any) -> float:
    return float(duration.sec) + float(duration.nanosec) / 1e9
