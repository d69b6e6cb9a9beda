"""A base with wheels on two sides is driven back along its way, with the arm as it was at each place."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.primitives.restoring.retrace import RETURN_TOLERANCE, _way_back, retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Moment, Trace
from handcart.robotics.geometry.pose2 import Pose2

from .rolling_car import PERIOD, Car, ramp


class Cart(Car):
    """Base that turns on the spot, with an arm and fingers; commands beyond its limits are errors."""

    held = None

    def __init__(self) -> None:
        super().__init__()
        self.spec = SimpleNamespace(tolerance=self.spec.tolerance, drive=SimpleNamespace(kind="differential"))
        self.grips: list[tuple[float, float, float]] = []
        self.gripper = SimpleNamespace(move=self._grip)

    def _grip(self, width: float) -> None:
        self.grip = width
        self.grips.append((self.true.x, self.joints[0], width))

    def drive(self, speed: float, turn_rate: float) -> None:
        assert abs(speed) <= self.drive_limits.speed + 1e-9
        assert abs(turn_rate) <= self.drive_limits.turn_rate + 1e-9
        super().drive(speed, turn_rate)

    def bring_back(self, start: Snapshot, trace: Trace) -> int:
        """Retrace; return the number of periods."""
        robot: Any = self
        return self.play(retrace(robot, start, trace))

    def is_back(self, start: Snapshot) -> bool:
        return (
            self.true.distance(start.pose) <= RETURN_TOLERANCE.position
            and self.true.turn(start.pose) <= RETURN_TOLERANCE.heading
            and self.joints.tolist() == start.joint_command.tolist()
            and self.grip == start.gripper_command
        )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("turn_rate", [0.0, 0.3])
def test_way_is_driven_back_the_arm_as_it_was_there(sign: float, turn_rate: float) -> None:
    cart = Cart()
    start, trace = cart.record(ramp(sign * 0.4, 60, turn_rate))
    periods = cart.bring_back(start, trace)
    assert cart.is_back(start)
    assert periods < 250
    driven = PERIOD * np.array([speed for speed, _ in cart.drives])
    assert np.sum(-sign * driven) == pytest.approx(1.2, abs=0.03)
    assert np.sum(np.abs(driven)) < 1.3
    by_place = {round(moment.joints[0], 6): moment.pose.x for moment in trace.moments[1:]}
    first = [joints[0] for _, joints in cart.arms]
    assert first == sorted(first, reverse=True)
    late = [abs(x - by_place[round(joints[0], 6)]) for x, joints in cart.arms if joints[0] > 0.005]
    assert len(late) > 30
    assert max(late) < 0.05


@pytest.mark.parametrize("turn_rate", [0.4, -0.4])
def test_turn_on_the_spot_is_turned_back(turn_rate: float) -> None:
    cart = Cart()
    start, trace = cart.record(ramp(0.0, 40, turn_rate))
    cart.bring_back(start, trace)
    assert cart.is_back(start)
    assert sum(turned for _, turned in cart.drives) * PERIOD == pytest.approx(
        -40 * PERIOD * turn_rate, abs=0.01
    )


def test_motions_of_base_and_arm_are_undone_in_reverse_order() -> None:
    """The arm moved, the base drove 0.6 m, the arm moved on."""
    cart = Cart()
    early = [(0.0, 0.0, 0.02 * number) for number in range(1, 11)]
    drive = [(0.4, 0.0, 0.2)] * 30
    late = [(0.0, 0.0, 0.2 + 0.02 * number) for number in range(1, 11)]
    start, trace = cart.record([*early, *drive, *late])
    cart.bring_back(start, trace)
    assert cart.is_back(start)
    for x, joints in cart.arms:
        if joints[0] != pytest.approx(0.2):
            assert x == pytest.approx(0.6 if joints[0] > 0.2 else 0.0, abs=0.003)
    assert {round(joints[0], 6) for _, joints in cart.arms} >= {0.38, 0.2, 0.1, 0.0}


def test_first_steps_of_an_arm_that_is_played_back_are_slow() -> None:
    """The first step takes four periods, the next three, two, and then one each."""
    cart = Cart()
    start, trace = cart.record([(0.0, 0.0, 0.024 * number) for number in range(1, 9)])
    cart.bring_back(start, trace)
    steps = -np.diff([0.192, *(joints[0] for _, joints in cart.arms)])
    assert steps == pytest.approx([*[0.008] * 3, *[0.012] * 2, *[0.024] * 6])


def test_fingers_that_moved_on_the_way_move_back_at_rest() -> None:
    """Where the fingers moved, the arm's motion waits for the base, and so do the motions before it."""
    cart = Cart()
    start, trace = cart.record(ramp(0.4, 60))
    trace.moments[:30] = [moment._replace(grip=0.04) for moment in trace.moments[:30]]
    start = replace(start, gripper_command=0.04)
    cart.bring_back(start, trace)
    assert cart.is_back(start)
    ((x, joint, width),) = cart.grips
    assert (x, width) == pytest.approx((0.0, 0.04), abs=0.01)
    assert joint == pytest.approx(trace.moments[30].joints[0])
    assert [joints[0] for _, joints in cart.arms][-3:] == pytest.approx([0.01, 0.0, 0.0], abs=0.011)


def test_distances_on_the_way_back_ignore_jitter() -> None:
    """Points are 20 mm apart at least; each moment has the distance of the last point before it."""
    ways = [0.0, 0.012, 0.024, 0.036, 0.048, 0.060]
    moments = [Moment(Pose2(1.0 + way, 2.0, 0.0), np.empty(0), 0.0) for way in ways]
    points, along = _way_back(moments)
    assert points == pytest.approx(np.array([[1.060, 2.0], [1.036, 2.0], [1.0, 2.0]]))
    assert along == pytest.approx([0.048, 0.048, 0.024, 0.024, 0.0, 0.0])
    jitter = [
        moment._replace(pose=moment.pose.compose(Pose2(0.0, 0.009 * (-1) ** k, 0.0)))
        for k, moment in enumerate([moments[0]] * 6)
    ]
    assert math.hypot(*(_way_back(jitter)[0][0] - [1.0, 2.009 - 0.018])) < 1e-9
    assert not _way_back(jitter)[1].any()
