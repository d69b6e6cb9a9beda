"""A pull is found beside bumps, tremor, pushes and weight."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np
import pytest

from handcart.primitives.objects.holding.pull_watch import PullWatch, direction_words
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.numerics.arrays import FloatArray

PERIOD_S = 0.05
LEAST_N = 6.0
WEIGHT = np.array([0.0, 0.0, -3.0])
AHEAD, LEFT, UP = np.eye(3)


class FeltRobot:
    """A hand 0.6 m ahead of the robot, with a force on it; all times are periods of 0.05 s."""

    period = PERIOD_S

    def __init__(self, noise: float = 0.3) -> None:
        self.rng, self.noise = np.random.default_rng(5), noise
        self.force = WEIGHT
        self.time = 0.0
        self.arm = self

    def base_T(self, frame: str) -> FloatArray:
        pose = np.eye(4)
        pose[:3, 3] = (0.6, 0.0, 0.9)
        return pose

    def hand_force(self) -> FloatArray:
        return np.asarray(self.force + self.noise * self.rng.standard_normal(3))


def finish(periods: Generator[None, None, Any]) -> Any:
    while True:
        try:
            next(periods)
        except StopIteration as end:
            return end.value


@pytest.fixture(autouse=True)
def rests_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def settle(robot: object) -> Generator[None, None, bool]:
        yield
        return True

    monkeypatch.setattr("handcart.primitives.objects.holding.pull_watch.settle", settle)


def watch_at_rest(robot: FeltRobot, early: FloatArray = np.zeros(3)) -> PullWatch:
    """Return a watch that has measured the force at rest, `early` being there as the hand arrives."""
    watch = PullWatch(robot, LEAST_N)  # type: ignore[arg-type]
    finish(watch.measure_rest())
    robot.force = WEIGHT + early
    finish(watch.rest_here())
    return watch


def pulls_in(watch: PullWatch, robot: FeltRobot, forces: list[FloatArray]) -> list[int]:
    """Return the periods in which a pull is found."""
    found = []
    for period, force in enumerate(forces):
        robot.force = WEIGHT + force
        watch.feel()
        if watch.pull() is not None:
            found.append(period)
    return found


@pytest.mark.parametrize("direction", [AHEAD, LEFT, -LEFT, UP, -UP, (AHEAD + UP) / np.sqrt(2)])
def test_pull_that_lasts_is_found_in_any_direction_but_back(direction: FloatArray) -> None:
    robot = FeltRobot()
    found = pulls_in(watch_at_rest(robot), robot, [10.0 * direction] * 12)
    assert found[0] in (6, 7)


@pytest.mark.parametrize(
    "forces",
    [
        [40.0 * AHEAD] * 3 + [0.0 * AHEAD] * 20,  # a bump
        [-10.0 * AHEAD] * 20,  # a push towards the robot
        [sign * 15.0 * LEFT for sign in (1.0, 1.0, -1.0, -1.0)] * 5,  # vibration
        [4.0 * AHEAD] * 20,  # too weak
        [12.0 * AHEAD] * 6 + [0.0 * AHEAD] * 14,  # let go at once
    ],
)
def test_what_is_no_pull_opens_nothing(forces: list[FloatArray]) -> None:
    robot = FeltRobot()
    assert pulls_in(watch_at_rest(robot), robot, forces) == []


def test_force_that_is_there_as_the_hand_arrives_is_no_weight() -> None:
    robot = FeltRobot()
    watch = watch_at_rest(robot, early=8.0 * UP)
    assert pulls_in(watch, robot, [8.0 * UP] * 20) == []  # held already: nobody has begun to pull
    assert pulls_in(watch, robot, [0.0 * UP] * 20) == []  # letting go is no pull downwards
    assert pulls_in(watch, robot, [8.0 * UP] * 20)[0] in (6, 7)


@pytest.mark.parametrize(("early", "refused"), [(0.0, False), (4.0, False), (8.0, True)])
def test_force_beside_the_weight_at_the_start_is_refused(early: float, refused: bool) -> None:
    robot = FeltRobot()
    robot.force = WEIGHT + early * UP
    watch = PullWatch(robot, LEAST_N)  # type: ignore[arg-type]
    if not refused:
        finish(watch.measure_rest(3.0))
        return
    with pytest.raises(Discrepancy, match="somebody pulls already"):
        finish(watch.measure_rest(3.0))


def test_pull_that_ends_as_the_fingers_open_no_longer_lasts() -> None:
    robot = FeltRobot()
    watch = watch_at_rest(robot)
    pulls_in(watch, robot, [10.0 * AHEAD] * 10)
    pull = watch.pull()
    assert pull is not None and watch.lasts(pull)
    pulls_in(watch, robot, [4.0 * AHEAD])
    assert not watch.lasts(pull)


def test_noise_that_hides_a_pull_is_refused() -> None:
    with pytest.raises(Discrepancy, match="the noise of the force hides a pull"):
        watch_at_rest(FeltRobot(noise=4.0))


def test_reading_that_stands_still_is_a_fault() -> None:
    robot = FeltRobot()
    watch = watch_at_rest(robot)
    pulls_in(watch, robot, [10.0 * AHEAD] * 4)
    robot.noise = 0.0
    with pytest.raises(Discrepancy, match="stands still"):
        pulls_in(watch, robot, [10.0 * AHEAD] * 10)


def test_missing_reading_is_no_pull_and_keeps_nobody_waiting() -> None:
    robot = FeltRobot()
    watch = watch_at_rest(robot)
    pulls_in(watch, robot, [np.zeros(3)] * 10)
    assert pulls_in(watch, robot, [np.full(3, np.nan)] * 4) == []
    assert watch.is_calm
    with pytest.raises(Discrepancy, match="the force on the hand isn't measured"):
        pulls_in(watch, robot, [np.full(3, np.nan)] * 4)


def test_directions_have_words() -> None:
    assert [direction_words(item) for item in (AHEAD, -LEFT, -UP)] == ["ahead", "right", "down"]
