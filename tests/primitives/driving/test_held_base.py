"""A base that something low holds while its wheels turn: it stops, and takes no wall for people."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from benchmarks.driving.cluttered_robot import write_robot
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome
from tests.primitives.conftest import Rig

ASIDE = Place(x_m=5.0, y_m=1.0, heading_deg=0.0)
AHEAD = Place(x_m=1.0, y_m=4.0, heading_deg=90.0)
POST = "  - {{name: {name}, x_m: {x}, y_m: {y}, size_m: [0.06, 0.06, 0.15]}}\n"  # below the lidar
BESIDE = POST.format(name="post", x=1.3, y=0.9)  # at its rear right corner, once it turns to the right
BEFORE = POST.format(name="post", x=1.0, y=1.6)


class Seen(NamedTuple):
    """What happened in an attempt, by the ground truth."""

    outcome: Outcome
    pushed_s: float
    """Longest time of contact while the base was driven, in [s]."""
    people: int
    """Maximum number of people in a period; zero is expected."""
    errors: list[tuple[bool, float, float]]
    """Whether the pose was settled in each period, and its error in sigmas and in [deg]."""


def attempt_of(rig: Rig, place: Place) -> Seen:
    """Drive to a place, and watch by the ground truth."""
    rig.model.places = {**rig.model.places, "there": place}
    step, pushed, people, errors, longest = rig.robot.step, 0.0, 0, [], 0.0

    def and_look(paused: bool = False) -> None:
        nonlocal pushed, people, longest
        step(paused)
        robot, base = rig.robot, rig.scene.base
        touches = any(pair[0] == "base" for pair in rig.scene.touching)
        pushed = pushed + robot.period if touches and any(robot.command) else 0.0
        longest, people = max(longest, pushed), max(people, len(robot.people.now(robot.time)))
        off = np.array([robot.pose.x - base.x, robot.pose.y - base.y, robot.pose.turn(base)])
        spread = robot.localization.covariance
        sigmas = max(abs(off[2]) / math.sqrt(spread[2, 2]), float(np.hypot(*off[:2])) / _worst(spread))
        errors.append((robot.localization.held_base.is_settled, sigmas, math.degrees(off[2])))

    rig.robot.step = and_look  # type: ignore[method-assign]
    return Seen(rig.run(MoveTo(place="there")), longest, people, errors)


def _worst(spread: np.ndarray) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(spread[:2, :2])[-1]))


@pytest.fixture
def box_rig(make_rig: Callable[..., Rig], tmp_path: Path) -> Callable[..., Rig]:
    """Builds a rig of a box on two wheels: contact keeps it from turning, too."""

    def make(furniture: str, localizer: str, seed: int = 0) -> Rig:
        robot = write_robot(tmp_path, (0.5, 0.43), 0.6, localizer)
        return make_rig(furniture=furniture, localizer=localizer, robot=str(robot), seed=seed)

    return make


@pytest.mark.parametrize("localizer", ["scan", "odometry"])
@pytest.mark.parametrize(("furniture", "place"), [(BESIDE, ASIDE), (BEFORE, AHEAD)], ids=["turn", "ahead"])
def test_a_held_base_stops_and_knows_where_it_is(
    box_rig: Callable[..., Rig], localizer: str, furniture: str, place: Place
) -> None:
    rig = box_rig(furniture, localizer)
    seen = attempt_of(rig, place)
    assert isinstance(seen.outcome, Fail | GiveUp)
    assert seen.outcome.cause is causes.BASE_STOPPED
    assert 0.0 < seen.pushed_s <= 1.0
    assert seen.people == 0
    assert abs(seen.errors[-1][2]) < 1.0
    assert max(sigmas for settled, sigmas, _ in seen.errors[-20:] if settled) < 4.0
    assert rig.robot.localization.held_base.is_settled


def test_a_base_held_at_one_wheel_by_a_foot_stops(make_rig: Callable[..., Rig]) -> None:
    """The left wheel turns on the floor without a grip, from one metre on."""
    rig = make_rig(localizer="odometry", robot="cart")
    rolling = rig.robot.backend._base._rolling  # type: ignore[attr-defined]
    free = rolling.motion
    rolling.motion = lambda left, right, period: free(left if rig.robot.time < 4.0 else 0.0, right, period)
    began = rig.robot.time
    seen = attempt_of(rig, AHEAD)
    assert isinstance(seen.outcome, Fail | GiveUp)
    assert seen.outcome.cause is causes.BASE_STOPPED
    assert rig.restored
    assert began < 4.0
