"""A base backs off from what stopped it, on the way on which it came, slowly and straight at first."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.primitives.restoring.back_off import (
    BACK_OFF_SPEED_M_S,
    BACK_OFF_TIMEOUT_S,
    MAX_CURVATURE_PER_M,
    STRAIGHT_M,
    STRAIGHT_SPEED_M_S,
    back_off,
)
from handcart.primitives.restoring.trace import Moment, Trace
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.blocked_motion import Blocked
from handcart.robotics.navigation.following.drive_limits import DriveLimits

PERIOD_S, RADIUS_M, LIMITS = 0.05, 0.2, DriveLimits(acceleration=0.6)
BEGAN = Pose2(3.0, -1.0, 0.4)


class Wheels:
    """Base without errors that was driven to where it stands, with a record of its way and its commands."""

    def __init__(self, sign: float, turn_rates: list[float], direction: float = 0.0) -> None:
        """Drive 20 mm in each period, ahead or back, with these turn rates in [rad/s]."""
        self.pose, self.time, self.period = BEGAN, 0.0, PERIOD_S
        self.spec, self.drive_limits = SimpleNamespace(footprint_radius_m=RADIUS_M), LIMITS
        self.base, self.stuck, self.sign, self.direction = self, False, sign, direction
        self.commands: list[tuple[float, float]] = []
        robot: Any = self
        self.trace = Trace(robot)
        for turn_rate in [0.0, *turn_rates]:
            self.trace.moments.append(Moment(Pose2(9.0, 9.0, 9.0), np.empty(0), 0.0, self.pose))
            self._move(sign * 0.4, turn_rate)
        self.pose = self.trace.moments[-1].odometry_pose or BEGAN
        self.stopped = self.pose

    @property
    def localization(self) -> Any:
        return SimpleNamespace(odometry_pose=self.pose)

    def drive(self, speed: float, turn_rate: float, sideways: float = 0.0) -> None:
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        assert sideways * cos == pytest.approx(speed * sin)  # in the direction in which it came
        along = speed * cos + sideways * sin
        self.commands.append((along, turn_rate))
        if not self.stuck:
            self._move(along, turn_rate)

    def _move(self, along: float, turn_rate: float) -> None:
        way = Pose2(0.0, 0.0, self.direction).apply(np.array([along * PERIOD_S, 0.0]))
        x, y = way.tolist()
        self.pose = self.pose.compose(Pose2(x, y, turn_rate * PERIOD_S))

    def back_off(self, at: Pose2 | None = None) -> None:
        """Back off from where it was stopped, or from another pose."""
        pose = (at or self.stopped).compose(Pose2(0.0, 0.0, self.direction))
        robot: Any = self
        blocked = Blocked(pose, pose.theta, self.sign > 0.0, 0.1, 0.1, 0.0, self.direction)
        for _ in back_off(robot, blocked, self.trace):
            self.time += PERIOD_S


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("direction", [0.0, 0.5 * math.pi])
def test_straight_way_is_driven_back_by_the_footprint(sign: float, direction: float) -> None:
    """At most 0.1 m/s for 30 mm, then at most 0.2 m/s, by 0.6 m/s² each; until 400 mm are between them."""
    robot = Wheels(sign, [0.0] * 40, direction)
    robot.back_off()
    assert robot.pose.distance(robot.stopped) == pytest.approx(2.0 * RADIUS_M, abs=0.021)
    assert robot.pose.distance(BEGAN) == pytest.approx(0.8 - 2.0 * RADIUS_M, abs=0.021)
    speeds = -sign * np.array([speed for speed, _ in robot.commands])
    assert speeds[:6] == pytest.approx([0.03, 0.06, 0.09, STRAIGHT_SPEED_M_S, *[STRAIGHT_SPEED_M_S] * 2])
    straight = int(np.sum(np.cumsum(speeds * PERIOD_S) < STRAIGHT_M)) + 1
    assert speeds[:straight].max() == STRAIGHT_SPEED_M_S
    assert np.diff(speeds).max() <= LIMITS.acceleration * PERIOD_S + 1e-9
    assert speeds[-1] == BACK_OFF_SPEED_M_S
    assert [turn_rate for _, turn_rate in robot.commands] == pytest.approx(np.zeros(len(speeds)), abs=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("turn_rate", [0.5, -0.5])
def test_curved_way_is_driven_back_with_its_headings(sign: float, turn_rate: float) -> None:
    robot = Wheels(sign, [turn_rate] * 20)
    robot.back_off()
    straight = [turned for along, turned in robot.commands if abs(along) <= STRAIGHT_SPEED_M_S]
    assert not any(straight[:-1])
    assert robot.pose.turn(robot.stopped) > 0.8 * 20 * 0.5 * PERIOD_S
    assert robot.pose.turn(BEGAN) < 0.1
    assert robot.pose.distance(BEGAN) < 0.05
    for along, turned in robot.commands:
        assert abs(turned) <= MAX_CURVATURE_PER_M * abs(along) + 1e-9
        assert turned * turn_rate <= 1e-9


def test_wrong_heading_is_corrected_by_no_sharp_turn() -> None:
    """Wheels that kept driving turned the base by 40 degrees."""
    robot = Wheels(1.0, [0.0] * 40)
    robot.pose = robot.pose.compose(Pose2(0.0, 0.0, math.radians(40.0)))
    robot.back_off()
    sharpest = min(turned / abs(along) for along, turned in robot.commands)
    assert sharpest == pytest.approx(-MAX_CURVATURE_PER_M)
    assert abs(robot.pose.theta - robot.stopped.theta) < math.radians(12.0)


@pytest.mark.parametrize(("came_m", "length_m"), [(0.2, 0.2), (0.0, STRAIGHT_M)])
def test_short_way_is_driven_back_and_30_mm_at_least(came_m: float, length_m: float) -> None:
    robot = Wheels(1.0, [0.0] * round(came_m / 0.02))
    robot.back_off()
    assert robot.pose.distance(robot.stopped) == pytest.approx(length_m, abs=0.011)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rebound_m", [-0.1, 0.1])
def test_distance_is_from_where_it_was_stopped(sign: float, rebound_m: float) -> None:
    """A rebound is part of it, and a slide past the place has to be driven first."""
    robot = Wheels(sign, [0.0] * 60)
    robot.pose = robot.stopped.compose(Pose2(-sign * rebound_m, 0.0, 0.0))
    robot.back_off()
    assert robot.pose.distance(robot.stopped) == pytest.approx(2.0 * RADIUS_M, abs=0.021)
    driven = sum(abs(along) for along, _ in robot.commands) * PERIOD_S
    assert driven == pytest.approx(2.0 * RADIUS_M - rebound_m, abs=0.03)
    first = 0.2 if rebound_m > 0.0 else 0.1
    assert max(abs(along) for along, _ in robot.commands[:12]) == pytest.approx(first)


def test_base_that_stays_held_ends_after_its_time() -> None:
    robot = Wheels(1.0, [0.0] * 40)
    robot.stuck = True
    robot.back_off()
    assert robot.time == pytest.approx(BACK_OFF_TIMEOUT_S, abs=1.01 * PERIOD_S)
