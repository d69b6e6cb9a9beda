"""Success of LOCATE, ORIENT, MOVE_TO and MODIFY, held against the truth by a claimed and a fixed limit."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.judging.arrival_survey import ArrivalSurvey
from handcart.evaluation.judging.at_most import at_most
from handcart.primitives.driving.move_to import ARRIVAL_TOLERANCE
from handcart.primitives.knowledge.place import DirectedTolerance, Place
from handcart.primitives.outcomes.outcome import GiveUp, Outcome, Success
from handcart.robotics.geometry.pose2 import Pose2

ORIGIN = Pose2(0.0, 0.0, 0.0)


def objections(do: str, primitive: Any = None, base: Pose2 = ORIGIN, **run: Any) -> list[str]:
    """Return the survey's objections to a Success while the base truly is at `base`."""
    survey: Any = SimpleNamespace(run=SimpleNamespace(base_on_map=base, **run))
    claim: Any = SimpleNamespace(primitive=primitive)
    return ArrivalSurvey.effects[do](survey, claim)


def located(sigmas: tuple[float, float, float], base: Pose2, **where: Any) -> list[str]:
    """Objections to LOCATE, which found the origin with these sigmas of x, y and heading."""
    localization = SimpleNamespace(
        **{"covariance": np.diag(sigmas) ** 2, "is_located": True, "lost": None, **where}
    )
    return objections("LOCATE", base=base, robot=SimpleNamespace(pose=ORIGIN, localization=localization))


@pytest.mark.parametrize(
    ("sigma_m", "off_m", "words"),
    [
        (0.02, 0.099, ""),
        (0.02, 0.101, "the base is 101.0 mm from where LOCATE found it (at most 100.0)"),
        (1.0, 0.149, ""),
        (1.0, 0.151, "the base is 151.0 mm from where LOCATE found it (at most 150.0)"),
    ],
)
@pytest.mark.parametrize("swap", [False, True])
def test_located_position_is_within_both_limits(sigma_m: float, off_m: float, words: str, swap: bool) -> None:
    """The claim is that of the worst direction, x or y."""
    sigmas = (0.001, sigma_m, 0.1) if swap else (sigma_m, 0.001, 0.1)
    assert located(sigmas, Pose2(0.0, off_m, 0.0)) == [words] * bool(words)


@pytest.mark.parametrize(
    ("sigma_deg", "off_deg", "words"),
    [
        (0.5, 2.4, ""),
        (0.5, -2.6, "the base heads 2.60 deg from what LOCATE found (at most 2.5)"),
        (9.0, 4.9, ""),
        (9.0, -5.1, "the base heads 5.10 deg from what LOCATE found (at most 5.0)"),
    ],
)
def test_located_heading_is_within_both_limits(sigma_deg: float, off_deg: float, words: str) -> None:
    found = located((0.1, 0.1, math.radians(sigma_deg)), Pose2(0.0, 0.0, math.radians(off_deg)))
    assert found == [words] * bool(words)


@pytest.mark.parametrize("unknown", [{"is_located": False}, {"lost": "its scans fit nowhere"}])
def test_success_of_locate_needs_a_known_pose(unknown: dict[str, Any]) -> None:
    assert located((0.1, 0.1, 0.1), ORIGIN, **unknown) == ["it isn't known where the base is"]


@pytest.mark.parametrize(
    ("sigma_deg", "off_deg", "words"),
    [
        (1.0, 5.2, ""),
        (1.0, -5.4, "the base heads 5.40 deg beside what is believed (at most 5.3)"),
        (9.0, 9.9, ""),
        (9.0, 10.1, "the base heads 10.10 deg beside what is believed (at most 10.0)"),
    ],
)
@pytest.mark.parametrize("is_known", [False, True])
def test_oriented_heading_is_known_and_within_both_limits(
    sigma_deg: float, off_deg: float, words: str, is_known: bool
) -> None:
    where = SimpleNamespace(heading_known=is_known, sigma=(9.0, math.radians(sigma_deg)))
    robot = SimpleNamespace(pose=Pose2(0.0, 0.0, math.radians(off_deg)), localization=where)
    expected = [words] * bool(words) if is_known else ["it isn't known which way the base heads"]
    assert objections("ORIENT", robot=robot) == expected


@pytest.mark.parametrize(
    ("ahead", "aside", "named"),
    [
        (0.044, 0.029, []),
        (-0.046, 0.0, ["along"]),
        (0.0, -0.031, ["across"]),
        (0.046, 0.031, ["along", "across"]),
    ],
)
def test_arrival_by_direction_is_held_against_the_claim(ahead: float, aside: float, named: list[str]) -> None:
    """The claim is 20 mm and 5 sigma in each direction: 45 mm along the heading and 30 mm across it."""
    assert ARRIVAL_TOLERANCE.position == pytest.approx(0.02)
    goal = Pose2(1.0, 2.0, 0.7)
    axes = np.array([[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]])
    covariance = np.diag([0.0, 0.0, 1e-6])
    covariance[:2, :2] = axes @ np.diag([0.005, 0.002]) ** 2 @ axes.T
    robot = SimpleNamespace(
        localization=SimpleNamespace(sigma=(0.005, 0.001), covariance=covariance),
        spec=SimpleNamespace(drive=SimpleNamespace(kind="differential")),
    )
    tolerance = DirectedTolerance(along=500.0, across=400.0)
    place = Place(x_m=1.0, y_m=2.0, heading_deg=math.degrees(0.7), tolerance_mm=tolerance)
    model = SimpleNamespace(places={"there": place})
    there = SimpleNamespace(place="there")
    found = objections("MOVE_TO", there, goal.compose(Pose2(ahead, aside, 0.0)), robot=robot, model=model)
    sizes = {"along": abs(1e3 * ahead), "across": abs(1e3 * aside)}
    most = {"along": 45.0, "across": 30.0}
    assert found == [
        f"the base is {sizes[name]:.1f} mm from its place, {name} its heading (at most {most[name]:.1f})"
        for name in named
    ]


@pytest.mark.parametrize(
    ("sigma_deg", "off_deg", "right"),
    [(0.02, 0.65, True), (0.02, 0.7, False), (9.0, 0.9, True), (9.0, 1.1, False)],
)
def test_arrival_heading_is_within_both_limits(sigma_deg: float, off_deg: float, right: bool) -> None:
    """The claim is the tolerance of driving and 5 sigma; a place needs 1 degree."""
    claimed = math.degrees(ARRIVAL_TOLERANCE.heading) + 5.0 * sigma_deg
    assert (off_deg <= min(claimed, 1.0)) is right
    robot = SimpleNamespace(
        localization=SimpleNamespace(sigma=(0.005, math.radians(sigma_deg))),
        spec=SimpleNamespace(drive=SimpleNamespace(kind="differential")),
    )
    model = SimpleNamespace(places={"there": Place(x_m=0.0, y_m=0.0, heading_deg=0.0)})
    base, there = Pose2(0.0, 0.0, math.radians(off_deg)), SimpleNamespace(place="there")
    assert (objections("MOVE_TO", there, base, robot=robot, model=model) == []) is right


@pytest.mark.parametrize(
    ("goal", "right"), [("there", True), ("here", False), ("yonder", False), (None, False)]
)
def test_success_of_modify_needs_a_way_to_its_own_place(goal: str | None, right: bool) -> None:
    model = SimpleNamespace(detour=None if goal is None else SimpleNamespace(goal=goal))
    found = objections("MODIFY", SimpleNamespace(place="there"), model=model)
    assert found == ([] if right else ["no other way is known"])


def test_figures_are_the_largest_of_successful_drives() -> None:
    drive, stand = (SimpleNamespace(label=lambda do=do: do, place="there") for do in ("MOVE_TO", "STAND"))
    early, late = (SimpleNamespace(label=lambda do=do: do, place="there") for do in ("DIG", "PICK"))
    run: Any = SimpleNamespace(
        model=SimpleNamespace(places={"there": Place(x_m=0.0, y_m=0.0, heading_deg=0.0)})
    )
    survey = ArrivalSurvey(run)
    ended: list[tuple[Any, Outcome, Pose2]] = [
        (drive, Success(), Pose2(0.003, 0.004567, math.radians(0.2))),
        (drive, Success(), Pose2(0.003, 0.0, math.radians(-0.31234))),
        (drive, GiveUp("somebody is on the path"), Pose2(0.5, 0.0, 0.5)),
        *((other, Success(), Pose2(0.7, 0.0, 0.7)) for other in (stand, early, late)),
    ]
    for number, (primitive, outcome, run.base_on_map) in enumerate(ended):
        assert survey.ended(number, primitive, outcome) == []
    assert survey.figures() == {"arrival_mm_max": 5.46, "arrival_deg_max": 0.312}


@pytest.mark.parametrize(
    ("size", "measured", "fixed", "shown"),
    [
        (2.0, 2.0, 3.0, None),
        (2.1, 2.0, 3.0, "2.0"),
        (3.0, 4.0, 3.0, None),
        (3.1, 4.0, 3.0, "3.0"),
        (5.0, 4.0, 3.0, "3.0"),
        (5.0, math.inf, math.inf, None),
        (0.0, math.nan, 3.0, "nan"),
        (math.nan, 4.0, 3.0, "3.0"),
    ],
)
def test_size_is_within_both_limits(size: float, measured: float, fixed: float, shown: str | None) -> None:
    found = at_most("{:.2f} mm off", size, measured, fixed)
    assert found == ([] if shown is None else [f"{size:.2f} mm off (at most {shown})"])
