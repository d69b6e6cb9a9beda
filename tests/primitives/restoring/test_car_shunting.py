"""A car that came back beside its start waits until its displacement is known, and is shunted there."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.joint_units import JointUnits
from handcart.primitives.restoring.car_shunting import (
    LONGEST_LOOK,
    LOOK_DURATION_S,
    MAX_SHUNTS,
    SHUNT_STUCK_S,
    bring_back,
)
from handcart.primitives.restoring.snapshot import Snapshot, take_snapshot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.odometry.watched_moment import Belief

PERIOD_S, SHARPEST_PER_M, NOTHING = 0.05, 0.5, np.empty((0, 3))
STARTED = Pose2(10.0, 5.0, 0.7)
CARRIED = Pose2(0.4, -0.3, 0.0)
"""Error of the pose on the map that has grown since the start; the displacement does not have it."""
BESIDE = Pose2(-0.9, 0.7, 0.2)


class Car:
    """Car outdoors that measures its displacement since the start better while it stands."""

    def __init__(self, off: Pose2, sure_after_s: float = 3.0, drift: float = 0.0) -> None:
        """Start at rest, `off` from the start; slide `drift` metres sideways for each one driven."""
        self.off, self.time, self.period = off, 0.0, PERIOD_S
        self.stood_s, self._sure_after_s, self._drift = 0.0, sure_after_s, drift
        self.hidden = Pose2(0.0, 0.0, 0.0)
        self.drives: list[tuple[float, float, float]] = []
        self.plans, self.is_stuck, self.points = 0, False, np.empty((0, 2))
        self.base, self.share_for_people, self.drive_limits = self, 1.0, DriveLimits(0.5, 0.35, 0.3)
        self.backend = SimpleNamespace(get=lambda kind: None)
        self.spec = SimpleNamespace(
            tolerance=SimpleNamespace(base_mm=100.0, base_deg=5.0, gripper_mm=1.0, object_mm=1.0),
            joint_units=JointUnits((), (), ()),
            drive=SimpleNamespace(sharpest_per_m=SHARPEST_PER_M),
            footprint_radius_m=0.6,
            footprint_shape=SimpleNamespace(distances=lambda points: np.hypot(*points.T) - 0.6),
            localizer="scan",
        )
        self._rolls = (0.0, 0.0)

    @property
    def pose(self) -> Pose2:
        return STARTED.compose(CARRIED).compose(self.off)

    @property
    def localization(self) -> Any:
        sigma = 0.01 if self.stood_s >= self._sure_after_s else 0.3
        return SimpleNamespace(
            odometry_pose=self.off,
            displacement=Belief(np.array(self.off), np.diag([sigma, sigma, 0.001]) ** 2),
            sigma=(0.5, 0.1),
            dead_reckoned=False,
            POSE_JUMPS=True,
            displacements=0,
            stale_s=0.0,
            look_again=lambda: None,
        )

    def surroundings(self) -> Any:
        return self.points

    def wheel_travel(self) -> WheelTravel:
        return WheelTravel(self.time if self.stood_s == 0.0 else 0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        assert abs(turn_rate) <= 1.01 * SHARPEST_PER_M * abs(speed) + 1e-9
        self.drives.append((self.time, speed, turn_rate))
        self._rolls = speed, turn_rate

    def step(self) -> None:
        speed, turn_rate = self._rolls
        self.time, self._rolls = self.time + PERIOD_S, (0.0, 0.0)
        self.stood_s = 0.0 if speed else self.stood_s + PERIOD_S
        if speed and not self.is_stuck:
            way = speed * self.share_for_people * PERIOD_S
            self.off = self.off.compose(Pose2(way, 0.0, turn_rate * self.share_for_people * PERIOD_S))
            self.hidden = Pose2(0.0, self.hidden.y + self._drift * abs(way), 0.0)
        elif self.stood_s > 0.2:  # at rest it is noticed
            self.off, self.hidden = self.off.compose(self.hidden), Pose2(0.0, 0.0, 0.0)

    def wait(self, seconds: float) -> Generator[None, None, None]:
        end = self.time + seconds
        while self.time < end - 1e-9:
            yield

    def compute(self, work: Callable[..., Any], *args: Any) -> Generator[None, None, Any]:
        self.plans += 1
        yield from self.wait(0.2)
        return work(*args)

    def bring_back(
        self, room: float = math.inf, each: Callable[[], None] = lambda: None, **known: Any
    ) -> float:
        """Bring it back; return the distance that is left, in [m]."""
        robot: Any = self
        model: Any = SimpleNamespace(
            **{"discs": NOTHING, "obstacles": NOTHING[:, :2], "bumps": NOTHING, "arm_bumps": NOTHING, **known}
        )
        for _ in bring_back(robot, started(), model, room):
            each()
            self.step()
        return math.hypot(*self.off[:2])


def started() -> Snapshot:
    robot: Any = Car(Pose2(0.0, 0.0, 0.0))
    return replace(take_snapshot(robot, {}), pose=STARTED)


@pytest.mark.parametrize("off", [BESIDE, Pose2(0.0, 0.0, math.radians(-12.0))])
def test_car_beside_its_start_is_shunted_to_it_once_it_is_sure(off: Pose2) -> None:
    car = Car(off)
    assert car.bring_back() < 0.1
    assert abs(car.off.theta) < math.radians(5.0)
    assert car.plans in (1, 2)
    assert car.drives[0][0] >= 3.0
    assert car.drives[-1][0] < 60.0
    assert car.stood_s >= 3.0  # it is sure of where it came to, as well


@pytest.mark.parametrize(
    ("off", "room"),
    [
        (Pose2(0.06, 0.07, math.radians(4.0)), math.inf),
        (BESIDE, 0.049),
        (Pose2(0.02, 0.0, 0.0), 0.06),
    ],
)
def test_car_within_its_room_waits_until_it_is_sure(off: Pose2, room: float) -> None:
    """A room that is smaller than a car can stop in is not driven for."""
    car = Car(off)
    car.bring_back(room)
    assert (car.drives, car.plans) == ([], 0)
    assert 3.0 <= car.time <= 3.0 + LOOK_DURATION_S


def test_room_of_the_action_is_held_as_the_files_tolerance_is() -> None:
    car = Car(Pose2(0.08, 0.0, 0.0))
    car.bring_back(room=0.06)
    assert car.plans >= 1
    assert car.off.x < 0.06


def test_car_that_never_becomes_sure_waits_its_time() -> None:
    car = Car(Pose2(0.06, 0.0, 0.0), sure_after_s=math.inf)
    car.bring_back()
    assert car.drives == []
    assert car.time == pytest.approx(LONGEST_LOOK, abs=1.1 * LOOK_DURATION_S)


@pytest.mark.parametrize("shown_by", ["model", "rock", "scan", "elsewhere"])
def test_start_that_something_stands_on_is_not_driven_to(shown_by: str) -> None:
    """The map's error since the start is in the pose and in known places alike."""
    car = Car(BESIDE)
    known: dict[str, Any] = {}
    there = STARTED.compose(CARRIED)
    if shown_by == "model":
        known = {"discs": np.array([[there.x, there.y, 0.1]])}
    elif shown_by == "rock":  # 1 m beside it: a rock may be 0.4 m off, and the car needs 0.75 m
        known = {"discs": np.array([[*there.compose(Pose2(0.0, -1.0, 0.0))[:2], 0.1]])}
    elif shown_by == "scan":
        car.points = BESIDE.inverse().apply(np.array([[0.0, 0.1]]))
    else:
        known = {"obstacles": np.array([[there.x + 6.0, there.y]])}
    is_back = car.bring_back(**known) < 0.1
    assert is_back is (shown_by == "elsewhere")
    assert bool(car.drives) is is_back


@pytest.mark.parametrize(("drift", "is_back"), [(0.02, True), (0.9, False)])
def test_car_that_slides_is_shunted_at_most_three_times(drift: float, is_back: bool) -> None:
    car = Car(BESIDE, drift=drift)
    assert (car.bring_back() < 0.1) is is_back
    assert car.plans in range(1, MAX_SHUNTS + 1) if is_back else car.plans == MAX_SHUNTS


def test_held_car_gives_up_unless_it_waits_for_a_person() -> None:
    held = Car(BESIDE)
    held.is_stuck = True
    assert held.bring_back() > 1.0
    assert held.plans == 1
    assert held.drives[-1][0] - held.drives[0][0] == pytest.approx(SHUNT_STUCK_S, abs=0.2)
    waits = Car(BESIDE)

    def let_pass() -> None:
        begun = waits.drives[0][0] if waits.drives else math.inf
        waits.share_for_people = 0.0 if begun + 2.0 < waits.time < begun + 22.0 else 1.0

    assert waits.bring_back(each=let_pass) < 0.1
    assert waits.plans in (1, 2)
