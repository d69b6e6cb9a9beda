"""NAVIGATE: drive to a place with Nav2."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, PrivateAttr

from handcart import ActionPrimitive, Base, CauseKind, Discrepancy, causes
from handcart.files.errors import HandcartError
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.outcomes.discrepancy import Measured

from .stacks import ENDED_STATES, GoalState, Navigator

NAV2_FAILED = CauseKind("nav2_failed", "Nav2 rejects or aborts the goal, or falls silent.")
ARRIVAL_SIGMAS = 3.0
"""Sigmas of the pose that an arrival includes."""


def connect_nav2() -> Navigator:
    """Return the real Nav2."""
    from .nav2 import Nav2

    return Nav2()


class Navigate(ActionPrimitive):
    """Drive the base to a named place by Nav2's planner and controller.

    Nav2 publishes its speeds on a topic of their own (remap its `cmd_vel`), and this primitive passes them on
    each period: the framework's guard, its limits and its watchdogs stay between Nav2 and the base, and
    the way that was driven is known. After a Discrepancy it is driven back. Nav2's word for its arrival is
    not believed: the pose is measured.
    """

    place: PlaceName
    """Goal."""
    tolerance_mm: Annotated[float, Field(gt=0.0)] = 100.0
    """Distance from the goal, 3 sigma included, that counts as arrived; Nav2's own checker allows 250 mm."""
    tolerance_deg: Annotated[float, Field(gt=0.0)] = 10.0
    """Heading off the goal, 3 sigma included, that counts as arrived."""
    silent_s: Annotated[float, Field(gt=0.0)] = 1.0
    """Time without speeds or an end after which Nav2 counts as silent."""
    limit_s: Annotated[float, Field(gt=0.0)] = 300.0
    """Time in which it has to arrive."""

    needs: ClassVar = (Base,)
    reads: ClassVar = ("places",)
    arm_inside: ClassVar = True
    connect: ClassVar[Callable[[], Navigator]] = staticmethod(connect_nav2)
    """Connects to Nav2; tests put their own in its place."""

    _nav2: Navigator | None = PrivateAttr(default=None)

    def unmet_precondition(self, robot, model):
        return "" if self.place in model.places else f"no place {self.place!r} is known"

    def motion(self, robot, model):
        goal = model.places[self.place].pose
        try:
            self._nav2 = yield from robot.compute(type(self).connect)
        except HandcartError as missing:
            raise Discrepancy(str(missing), permanent=True, cause=causes.UNSUITABLE) from None
        try:
            self._nav2.go_to(goal.x, goal.y, goal.theta)
            yield from self._follow(robot, self._nav2)
        finally:
            self._nav2.close()

    def _follow(self, robot, nav2):
        """Pass Nav2's speeds on until it has ended."""
        begun = heard = robot.time
        while (state := nav2.state()) not in ENDED_STATES:
            speeds = nav2.speeds()
            if speeds is not None:
                heard = robot.time
                if not all(map(math.isfinite, speeds)):
                    raise Discrepancy(f"Nav2 sends the speeds {speeds}", cause=NAV2_FAILED)
                self._drive(robot, speeds)
            elif (silent := robot.time - heard) > self.silent_s:
                measured = Measured("nav2", "silence", silent, self.silent_s, "s")
                words = f"Nav2 is silent ({state.value})"
                raise Discrepancy(words, measured=measured, cause=NAV2_FAILED)
            if robot.time - begun > self.limit_s:
                raise Discrepancy(f"not there after {self.limit_s:g} s", cause=causes.TIME_OUT)
            yield
        if state is not GoalState.SUCCEEDED:
            raise Discrepancy(f"Nav2: the goal is {state.value}", cause=NAV2_FAILED)

    @staticmethod
    def _drive(robot, speeds):
        """Drive within the limits of the base."""
        limits = robot.spec.drive
        top, top_turn = limits.top_speed_m_s, math.radians(limits.top_turn_deg_s)
        forward = min(max(speeds.forward_m_s, -top), top)
        robot.base.drive(forward, min(max(speeds.turn_rad_s, -top_turn), top_turn))

    def effect(self, robot, model):
        """Measure where the base is: an arrival is what handcart's localizer sees, not what Nav2 says."""
        goal, pose, covariance = model.places[self.place].pose, robot.pose, robot.localization.covariance
        sigma = math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2]).max()))
        off = 1e3 * (pose.distance(goal) + ARRIVAL_SIGMAS * sigma)
        turn = math.degrees(pose.turn(goal) + ARRIVAL_SIGMAS * math.sqrt(float(covariance[2, 2])))
        self.found(off_mm=round(off, 1), off_deg=round(turn, 2))
        return off <= self.tolerance_mm and turn <= self.tolerance_deg
        yield
