"""Everything that Success claims has a check, and each check can fail."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.ground_truth import Body, GroundTruth
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.blocks.block_survey import BlockSurvey
from handcart.evaluation.calibration.calibration_survey import CalibrationSurvey
from handcart.evaluation.field.field_survey import FieldSurvey
from handcart.evaluation.judging.arrival_survey import ArrivalSurvey
from handcart.evaluation.judging.base_surveys import LocalisationSurvey
from handcart.evaluation.judging.survey import Claim, Survey
from handcart.evaluation.judging.surveys import survey_kinds
from handcart.evaluation.judging.true_changes import disturbed, moved
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.field.target import Laid
from handcart.primitives.knowledge.place import DirectedTolerance, Place, Shelf
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.registry import primitive_names
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform

HERE = Pose2(0.0, 0.0, 0.0)


def truth(base: Pose2, **places: float) -> GroundTruth:
    """Return a stub of the ground truth: the base, and things with their x."""
    bodies = {}
    for name, x in places.items():
        pose = np.eye(4)
        pose[0, 3] = x
        bodies[name] = Body("table", pose)
    return GroundTruth(base, np.zeros(2), np.zeros(2, dtype=np.bool_), 0.0, bodies, 0)


def false(kind: type[Survey], do: str, claim: Claim, **run: Any) -> list[str]:
    """Return a survey's objections to a Success, given only these facts of the run."""
    if "world" in run:
        run.setdefault("base_on_map", getattr(run["world"], "base", None))
    survey: Any = SimpleNamespace(run=SimpleNamespace(**run))
    return kind.effects[do](survey, claim)


def claimed(primitive: Any = None, before: Pose2 = HERE, after: Pose2 = HERE) -> Claim:
    return Claim(primitive, truth(before), truth(after))


def test_every_primitive_has_a_check_of_its_success() -> None:
    """Of all domains, calibrations included; and no two surveys check the same claim."""
    checked = [name for kind in survey_kinds() for name in kind.effects]
    assert sorted(checked) == sorted(primitive_names())


def test_surveys_keep_their_notes_apart() -> None:
    names = [kind.name for kind in survey_kinds()]
    assert len(set(names)) == len(names)


def test_a_calibration_is_held_against_the_truth() -> None:
    wrong = {"camera.calibrated.k1": Calibrated(9.0, 0.01)}
    primitive = SimpleNamespace(evidence=SimpleNamespace(calibrated=wrong))
    spec = load_robot("toyama/uncalibrated")
    (untrue,) = false(CalibrationSurvey, "CALIBRATE_CAMERA", claimed(primitive), spec=spec, seed=3)
    assert untrue.startswith("k1 is 9")


def test_a_base_that_stood_stood() -> None:
    here = Pose2(1.0, 2.0, 0.1)

    def stood(after: Pose2, localizer: str = "scan") -> list[str]:
        spec = SimpleNamespace(localizer=localizer)
        return false(ArrivalSurvey, "STAND", claimed(None, here, after), spec=spec)

    assert stood(Pose2(1.002, 2.0, 0.101)) == []
    (wrong,) = stood(Pose2(1.01, 2.0, 0.1))
    assert wrong == "the base moved by 10.0 mm (at most 5.0)"
    assert stood(Pose2(1.04, 2.0, 0.1), "gps_filter") == []
    assert stood(Pose2(1.07, 2.0, 0.1), "gps_filter") != []
    (wrong,) = stood(Pose2(1.0, 2.0, 0.2))
    assert wrong.startswith("the base turned by 5.73 deg")


def test_what_a_primitive_disturbs_is_told_but_for_its_own() -> None:
    before, after = truth(Pose2(0, 0, 0), one=0.0, two=0.0), truth(Pose2(0, 0, 0), one=0.02, two=0.3)
    assert disturbed(before, after, 10.0, {"two"}) == ["one mm 20.0"]
    assert disturbed(before, after, 25.0, {"two"}) == []


@pytest.mark.parametrize(
    ("kind", "docks", "sigma", "off", "right"),
    [
        ("differential", False, 0.004, 0.039, True),
        ("differential", False, 0.004, 0.041, False),
        ("differential", True, 0.004, 0.023, True),
        ("differential", True, 0.004, 0.025, False),
        ("differential", False, 0.001, 0.026, False),
        ("differential", False, 0.736, 0.039, True),
        ("differential", False, 0.736, 0.042, False),
        ("differential", True, 0.736, 0.025, False),
        ("differential", False, math.inf, 0.0, False),
        ("ackermann", False, 0.0, 0.24, True),
        ("ackermann", False, 0.0, 0.26, False),
        ("ackermann", False, 0.3, 1.45, True),
        ("ackermann", False, 5.0, 1.55, False),
    ],
)
def test_arrival_is_held_against_what_is_claimed(
    kind: str, docks: bool, sigma: float, off: float, right: bool
) -> None:
    scene = SimpleNamespace(base=Pose2(1.0 + off, 2.0, 0.0))
    robot: Any = SimpleNamespace(
        pose=Pose2(1.25, 2.0, 0.0),  # a car claims its estimate, here 0.25 m off
        localization=SimpleNamespace(sigma=(sigma, 0.001)),
        spec=SimpleNamespace(drive=SimpleNamespace(kind=kind)),
    )
    shelf = Shelf(distance_m=0.6, width_m=0.9, board_m=0.4, front_m=0.9) if docks else None
    model: Any = SimpleNamespace(places={"there": Place(x_m=1.0, y_m=2.0, heading_deg=0.0, shelf=shelf)})
    claim = claimed(SimpleNamespace(place="there"))
    untrue = false(ArrivalSurvey, "MOVE_TO", claim, robot=robot, model=model, world=scene)
    assert (untrue == []) is right


@pytest.mark.parametrize(
    ("ahead", "aside", "right"), [(0.49, 0.039, True), (0.51, 0.0, False), (0.0, 0.041, False)]
)
def test_arrival_by_direction_has_a_fixed_limit_in_each(ahead: float, aside: float, right: bool) -> None:
    goal = Pose2(1.0, 2.0, 0.7)
    base = goal.compose(Pose2(ahead, aside, 0.0))
    robot: Any = SimpleNamespace(
        localization=SimpleNamespace(sigma=(0.5, 0.001), covariance=np.diag([0.25, 0.25, 1e-6])),
        spec=SimpleNamespace(drive=SimpleNamespace(kind="differential")),
    )
    tolerance = DirectedTolerance(along=500.0, across=40.0)
    place = Place(x_m=1.0, y_m=2.0, heading_deg=math.degrees(0.7), tolerance_mm=tolerance)
    model: Any = SimpleNamespace(places={"there": place})
    claim, world = claimed(SimpleNamespace(place="there")), SimpleNamespace(base=base)
    untrue = false(ArrivalSurvey, "MOVE_TO", claim, robot=robot, model=model, world=world)
    assert (untrue == []) is right


@pytest.mark.parametrize(("off_deg", "right"), [(19.9, True), (20.1, False)])
def test_a_cars_heading_is_judged_as_move_to_claims_it(off_deg: float, right: bool) -> None:
    """A place that says nothing has one default, for the primitive and the judge."""
    heading = math.radians(off_deg)
    covariance = np.diag([1e-4, 1e-4, math.radians(0.001) ** 2])
    robot: Any = SimpleNamespace(
        pose=Pose2(0.0, 0.0, heading),
        localization=SimpleNamespace(
            sigma=(0.01, 1.0),
            covariance=covariance,
            repeatability=covariance,
            map_shift=np.zeros(2),
            source="Gps",
        ),
        spec=SimpleNamespace(drive=SimpleNamespace(kind="ackermann")),
    )
    model: Any = SimpleNamespace(places={"there": Place(x_m=0.0, y_m=0.0, heading_deg=0.0)})
    world, claim = SimpleNamespace(base=robot.pose), claimed(SimpleNamespace(place="there"))
    untrue = false(ArrivalSurvey, "MOVE_TO", claim, robot=robot, model=model, world=world)
    assert (untrue == []) is right
    with nullcontext() if right else pytest.raises(Discrepancy):
        assert list(MoveTo(place="there").effect(robot, model)) == []


@pytest.mark.parametrize(("off_m", "right"), [(0.54, True), (0.56, False)])
def test_a_car_is_judged_by_its_own_estimate_and_five_sigma(off_m: float, right: bool) -> None:
    """It believes to be 50 mm off with a sigma of 0.1 m; its place needs no more than 1.5 m."""
    localization = SimpleNamespace(sigma=(0.1, 0.001), covariance=np.diag([1e-2, 1e-2, 1e-6]))
    drive = SimpleNamespace(drive=SimpleNamespace(kind="ackermann"))
    robot: Any = SimpleNamespace(pose=Pose2(0.05, 0.0, 0.0), localization=localization, spec=drive)
    model: Any = SimpleNamespace(places={"there": Place(x_m=0.0, y_m=0.0, heading_deg=0.0)})
    world, claim = SimpleNamespace(base=Pose2(off_m, 0.0, 0.0)), claimed(SimpleNamespace(place="there"))
    assert (false(ArrivalSurvey, "MOVE_TO", claim, robot=robot, model=model, world=world) == []) is right


@pytest.mark.parametrize(
    ("sigma_deg", "off_deg", "right"), [(1.0, 5.0, True), (1.0, 5.5, False), (30.0, 11.0, False)]
)
def test_a_heading_is_known_within_both_limits(sigma_deg: float, off_deg: float, right: bool) -> None:
    robot: Any = SimpleNamespace(
        localization=SimpleNamespace(sigma=(0.1, math.radians(sigma_deg)), heading_known=True),
        pose=Pose2(0.0, 0.0, math.radians(off_deg)),
    )
    untrue = false(ArrivalSurvey, "ORIENT", claimed(), robot=robot, world=SimpleNamespace(base=HERE))
    assert (untrue == []) is right


def laid_at(x: float, sigma: float = 0.01) -> Any:
    """A model in which one sensor is believed to lie at x."""
    laid = Laid("a", x, 0.0, (sigma**2, 0.0, sigma**2), (0.0, 0.0), 1.0)
    known = SimpleNamespace(laid=(laid,), targets={"a": SimpleNamespace(x=0.0, y=0.0)})
    return SimpleNamespace(of=lambda _: known)


def lying(x: float, rest: str = "table") -> Any:
    """A scene in which the sensor truly lies at x."""
    pose = np.eye(4)
    pose[0, 3] = x
    there = SimpleNamespace(sensors={"1": SimpleNamespace(pose=pose, rest=SimpleNamespace(value=rest))})
    return SimpleNamespace(of=lambda _: there)


def test_a_sensor_lies_where_it_is_believed_to_and_should() -> None:

    def deploy(world: Any, primitive: Any, model: Any) -> list[str]:
        return false(FieldSurvey, "DEPLOY", claimed(primitive), world=world, model=model)

    primitive = SimpleNamespace(target="a", sure_mm=250.0)
    assert deploy(lying(0.05), primitive, laid_at(0.04)) == []
    assert deploy(lying(0.05, "floor"), primitive, laid_at(0.05)) == [
        "the sensor doesn't stand on the ground"
    ]
    (wrong,) = deploy(lying(0.0), primitive, laid_at(0.1))
    assert wrong == "the sensor is 100 mm from where it is believed to be (at most 80.0)"
    (wrong,) = deploy(lying(0.1), primitive, laid_at(0.1))
    assert wrong == "the sensor is 100 mm from its target (at most 80.0)"
    assert deploy(lying(0.0), SimpleNamespace(target="b", sure_mm=250.0), laid_at(0.0)) == [
        "no sensor counts as laid there"
    ]


def test_a_sensor_is_within_the_sigma_that_was_waited_for() -> None:
    """However uncertain the claim is."""
    primitive = SimpleNamespace(target="a", sure_mm=100.0)

    def untrue(lies: float, sigma: float) -> list[str]:
        claim, model = claimed(primitive), laid_at(lies, sigma)
        return false(FieldSurvey, "DEPLOY", claim, world=lying(lies), model=model)

    assert untrue(0.5, 0.1) == []
    assert untrue(0.6, 0.1) == ["the sensor is 600 mm from its target (at most 530.0)"]
    assert untrue(0.6, 2.0) == ["the sensor is 600 mm from its target (at most 530.0)"]


def test_a_base_stands_and_is_turned_as_it_was_found() -> None:
    scene = SimpleNamespace(base=Pose2(1.0, 2.0, 0.5))

    def found(x: float, theta: float, sigma: tuple[float, float] = (1e-3, 1e-3)) -> list[str]:
        known = SimpleNamespace(fixed=SimpleNamespace(pose=Pose2(x, 2.0, theta), sigma=sigma))
        model: Any = SimpleNamespace(of=lambda _: known)
        return false(BlockSurvey, "FIXATE", claimed(), world=scene, model=model)

    assert found(1.005, 0.505) == []
    assert found(1.004, 0.5, (1e-4, 1e-4)) == ["the base is 4.0 mm from where it was found (at most 3.0)"]
    assert found(1.02, 0.5, (1.0, 1.0)) == ["the base is 20.0 mm from where it was found (at most 6.0)"]
    assert found(1.01, 0.5) == ["the base is 10.0 mm from where it was found (at most 6.0)"]
    assert found(1.0, 0.52) == ["the base is turned 1.15 deg against how it was found (at most 0.3)"]
    nothing: Any = SimpleNamespace(of=lambda _: SimpleNamespace(fixed=None))
    untrue = false(BlockSurvey, "FIXATE", claimed(), world=scene, model=nothing)
    assert untrue == ["it isn't known where the base stands"]


def test_what_another_thing_carries_now_is_infinitely_far() -> None:
    before, after = truth(Pose2(0, 0, 0), one=0.0), truth(Pose2(0, 0, 0), one=0.0)
    assert moved(before, after)["object one mm"] == 0.0
    held = replace(after, bodies={"one": replace(after.bodies["one"], support="hand")})
    assert moved(before, held)["object one mm"] == math.inf
    assert moved(before, replace(after, bodies={}))["object one mm"] == math.inf


def test_how_far_off_it_believed_to_be_is_told_by_squares_and_worst() -> None:
    run: Any = SimpleNamespace(base_on_map=Pose2(0.0, 0.0, 0.0))
    survey = LocalisationSurvey(run)
    assert survey.figures() == {}
    unlocated: Any = SimpleNamespace(
        pose=Pose2(9.0, 0.0, 0.0), localization=SimpleNamespace(is_located=False)
    )
    survey.look(unlocated)  # its pose is in a frame of its own
    located = SimpleNamespace(is_located=True)
    for off, turned in ((0.003, 0.0), (0.004, -0.02), (0.0, 0.01)):
        robot: Any = SimpleNamespace(pose=Pose2(off, 0.0, turned), localization=located)
        survey.look(robot)
    again = LocalisationSurvey(run)
    again.go_on(survey.notes())
    assert (
        again.figures()
        == survey.figures()
        == {
            "localisation_mm_rms": round(5.0 / math.sqrt(3), 2),
            "localisation_mm_max": 4.0,
            "localisation_deg_max": round(math.degrees(0.02), 3),
        }
    )


@pytest.mark.parametrize(
    ("x", "z", "roll", "yaw", "wrong"),
    [
        (0.010, 0.004, 0.5, 3.4, ""),
        (0.010, 0.0, 0.0, 180.0, ""),
        (0.011, 0.0, 0.0, 0.0, "the block is 11.0 mm from its goal"),
        (0.0, -0.06, 0.0, 0.0, "the block is 60.0 mm above or below its goal"),
        (0.0, 0.0, 90.0, 0.0, "the block is tilted by 90.0 deg"),
        (0.0, 0.0, 0.0, -4.0, "the block is turned by 4.0 deg"),
    ],
)
def test_a_stacked_block_is_at_its_goal_upright_and_not_turned(
    x: float, z: float, roll: float, yaw: float, wrong: str
) -> None:
    goal = Pose2(1.0, 2.0, 0.7).lift()
    off = transform((x, 0.0, z), rpy=(math.radians(roll), 0.0, math.radians(yaw)))
    block = SimpleNamespace(pose=goal @ off, rest=SimpleNamespace(value="table"))
    plan = SimpleNamespace(goals=[SimpleNamespace(pose=goal)])
    model: Any = SimpleNamespace(of=lambda _: SimpleNamespace(building=plan))
    world: Any = SimpleNamespace(of=lambda _: SimpleNamespace(blocks={"1": block}), base=HERE)
    claim = claimed(SimpleNamespace(number=1, onto="goal"))
    untrue = false(BlockSurvey, "STACK", claim, model=model, world=world)
    assert [item.partition(" (")[0] for item in untrue] == ([wrong] if wrong else [])
