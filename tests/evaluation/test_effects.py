"""Everything that Success claims has a check, and each check can fail."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from evaluation.effects import EFFECTS, _move_to, _stand
from evaluation.ground_truth import Body, GroundTruth, disturbed
from primitives.registry import TABLE
from primitives.target import Laid
from robotics.geometry.pose2 import Pose2

CALIBRATIONS = {"CALIBRATE_CAMERA", "CALIBRATE_SUSPENSION"}  # see `calibration_claims`
BY_THEMSELVES = {"MOVE_TO", "STAND"}


def truth(base: Pose2, **places: float) -> GroundTruth:
    """The base, and things by how far along x they stand."""
    bodies = {}
    for name, x in places.items():
        pose = np.eye(4)
        pose[0, 3] = x
        bodies[name] = Body("table", pose)
    return GroundTruth(base, np.zeros(2), np.zeros(2, dtype=np.bool_), 0.0, bodies, 0)


def test_every_primitive_has_a_check_of_its_success() -> None:
    assert set(TABLE) == set(EFFECTS) | CALIBRATIONS | BY_THEMSELVES


def test_a_base_that_stood_stood() -> None:
    here = Pose2(1.0, 2.0, 0.1)
    assert _stand(truth(here), truth(Pose2(1.002, 2.0, 0.101))) == []
    (wrong,) = _stand(truth(here), truth(Pose2(1.01, 2.0, 0.1)))
    assert wrong == "the base moved by 10.0 mm (at most 5.0)"
    (wrong,) = _stand(truth(here), truth(Pose2(1.0, 2.0, 0.2)))
    assert wrong.startswith("the base turned by 5.73 deg")


def test_what_a_primitive_disturbs_is_told_but_for_its_own() -> None:
    before, after = truth(Pose2(0, 0, 0), one=0.0, two=0.0), truth(Pose2(0, 0, 0), one=0.02, two=0.3)
    assert disturbed(before, after, 10.0, {"two"}) == ["one mm 20.0"]
    assert disturbed(before, after, 25.0, {"two"}) == []


@pytest.mark.parametrize(
    ("kind", "shelf", "sigma", "off", "right"),
    [
        ("differential", None, 0.004, 0.039, True),
        ("differential", None, 0.004, 0.041, False),
        ("differential", "one", 0.004, 0.023, True),
        ("differential", "one", 0.004, 0.025, False),
        ("differential", None, 0.030, 0.160, True),
        ("differential", None, math.inf, 0.0, False),
        ("ackermann", None, 0.0, 0.24, True),
        ("ackermann", None, 0.0, 0.26, False),
    ],
)
def test_arrival_is_held_against_what_is_claimed(kind, shelf, sigma, off, right) -> None:
    goal = Pose2(1.0, 2.0, 0.0)
    scene = SimpleNamespace(base=Pose2(1.0 + off, 2.0, 0.0))
    robot: Any = SimpleNamespace(
        backend=SimpleNamespace(scene=scene),
        pose_sigma=(sigma, 0.001),
        spec=SimpleNamespace(drive=SimpleNamespace(kind=kind)),
    )
    model: Any = SimpleNamespace(places={"there": SimpleNamespace(pose=goal, shelf=shelf)})
    assert (_move_to(robot, SimpleNamespace(place="there"), model) == []) is right


def laid_at(x: float) -> Any:
    """A model in which one sensor is believed to lie at x."""
    laid = Laid("a", x, 0.0, (1e-4, 0.0, 1e-4), (0.0, 0.0), 1.0)
    return SimpleNamespace(laid=(laid,), targets={"a": SimpleNamespace(x=0.0, y=0.0)})


def lying(x: float, rest: str = "table") -> Any:
    """A scene in which the sensor truly lies at x."""
    pose = np.eye(4)
    pose[0, 3] = x
    return SimpleNamespace(blocks={"1": SimpleNamespace(pose=pose, rest=SimpleNamespace(value=rest))})


def test_a_sensor_lies_where_it_is_believed_to_and_should() -> None:
    deploy, primitive = EFFECTS["DEPLOY"], SimpleNamespace(target="a")
    assert deploy(lying(0.05), primitive, laid_at(0.04)) == []
    assert deploy(lying(0.05, "floor"), primitive, laid_at(0.05)) == [
        "the sensor doesn't stand on the ground"
    ]
    (wrong,) = deploy(lying(0.0), primitive, laid_at(0.1))
    assert wrong == "the sensor is 100 mm from where it is believed to be (at most 80.0)"
    (wrong,) = deploy(lying(0.1), primitive, laid_at(0.1))
    assert wrong == "the sensor is 100 mm from its target (at most 80.0)"
    assert deploy(lying(0.0), SimpleNamespace(target="b"), laid_at(0.0)) == ["no sensor counts as laid there"]
