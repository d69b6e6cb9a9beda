"""Keeps the base off ground that its lidar can't see and that it has not just driven over."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import ClassVar

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.robot.localization.lidar import Lidar
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.footprint_guard import SensorView
from handcart.robotics.navigation.following.unseen_ground import is_driven, unseen_edge
from handcart.robotics.navigation.following.way_guard import HoldingObstacle

DRIVEN_STEP_M = 0.02
DRIVEN_S = 60.0
"""Time for which ground stays free after the base drove over it; the current action's ground always is."""


class UnseenGround:
    """Guard that keeps the base off ground that its lidar does not see.

    Unseen ground is outside the lidar's field of view, in masked sectors, and along beams that are too close
    or invalid. The base enters unseen ground only where it has driven in the current action or in the last
    minute, which lets it drive back along its route.
    """

    STATE: ClassVar[Kinds] = {"_driven": list[tuple[float, float, float]]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(
        self, lidar: Lidar, radius: float, rolled: Callable[[], Pose2], clock: Callable[[], float]
    ) -> None:
        """Watch the ground of a base.

        Args:
            lidar: lidar that sees the ground.
            radius: radius of the footprint, in [m].
            rolled: returns the 2D pose of the base in a frame in which it does not jump.
            clock: returns the robot's time, in [s].
        """
        self._lidar, self._radius, self._rolled, self._clock = lidar, radius, rolled, clock
        self._driven: list[tuple[float, float, float]] = []

    @property
    def is_partial(self) -> bool:
        """True if the lidar has masked sectors, or a field of view of less than a full turn."""
        return bool(self._lidar.spec.masked_deg) or not self._lidar.spec.is_full_turn

    @cached_property
    def view(self) -> SensorView:
        """Field of view of the lidar in the base frame; empty (a negative width) if the robot's file excludes
        sectors of the lidar (`masked_deg`).
        """
        scan = self._lidar.scan()
        mount, spec = scan.base_T_sensor, self._lidar.spec
        width = math.radians(spec.end_deg - spec.start_deg)
        start = mount.theta + math.radians(spec.start_deg)
        return SensorView(mount.x, mount.y, start, -1.0 if spec.masked_deg else width)

    def starts_here(self) -> None:
        """Begin a new action: forget the places where the base drove more than a minute ago (`DRIVEN_S`)."""
        since = self._clock() - DRIVEN_S
        self._driven = [spot for spot in self._driven if spot[2] >= since]

    def forget(self) -> None:
        """Forget where the base has driven, because the frame of its poses has changed."""
        self._driven = []

    def held(
        self, pose: Pose2, curvature: float, length: float, direction: float = 0.0
    ) -> HoldingObstacle | None:
        """Return the first ground on an arc that the lidar does not see; None if it sees all ground on the
        arc, or the base has driven there before.

        Args:
            pose: pose on the map that heads in the direction of travel.
            curvature: curvature of the arc, in [1/m], positive to the left.
            length: length of the arc, in [m], negative backwards.
            direction: direction of travel in the base frame, in [rad], counter-clockwise from straight ahead.
        """
        scan, here = self._lidar.scan(), self._rolled()
        way_T_sensor = scan.base_T_sensor
        if direction != 0.0:
            base_T_way = Pose2(0.0, 0.0, direction)
            way_T_sensor, here = base_T_way.inverse().compose(way_T_sensor), here.compose(base_T_way)
        found = unseen_edge(scan.angles, scan.blind(), way_T_sensor, self._radius, curvature, length)
        if not self._driven:
            self._remember(here)
        if found is None:
            self._remember(here)
            return None
        driven = np.array(self._driven)[:, :2]
        if is_driven(driven, here, curvature, length):
            return None
        x, y = pose.apply(found[None])[0].tolist()
        return HoldingObstacle("unseen", x, y, math.hypot(*found), self._radius)

    def _remember(self, here: Pose2) -> None:
        last = self._driven[-1] if self._driven else None
        if last is None or math.hypot(here.x - last[0], here.y - last[1]) >= DRIVEN_STEP_M:
            self._driven.append((here.x, here.y, self._clock()))
        else:
            self._driven[-1] = (last[0], last[1], self._clock())
