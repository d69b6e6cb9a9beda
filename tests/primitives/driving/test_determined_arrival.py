"""MOVE_TO claims no arrival that the sensors do not determine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from handcart.backends.robot.localization.determination import PoseNeed
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving import move_to
from handcart.primitives.driving.docking import check_front
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.scans.front_line import FrontLine

CELL_M, LENGTH_M, WIDTH_M = 0.05, 40.0, 3.2


def in_a_corridor(folder: Path, tolerance: str = "") -> Rig:
    """Two straight walls; their ends are out of the lidar's reach."""
    picture = np.full((round(WIDTH_M / CELL_M), round(LENGTH_M / CELL_M)), 254, np.uint8)
    picture[:3] = picture[-3:] = picture[:, :3] = picture[:, -3:] = 0
    cv2.imwrite(str(folder / "map.png"), picture)
    thresholds = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    text = f"image: map.png\nresolution: {CELL_M}\norigin: [0.0, 0.0, 0.0]\n{thresholds}"
    (folder / "map.yaml").write_text(text)
    places = f"""\
format: handcart-places/1
places:
  home: {{x_m: 20.0, y_m: 1.6, heading_deg: 0.0}}
  ahead: {{x_m: 21.0, y_m: 1.6, heading_deg: 0.0{tolerance}}}
"""
    (folder / "places.yaml").write_text(places)
    files = RigFiles(folder / "map.yaml", folder / "map.yaml", folder / "places.yaml", {})
    return build_rig(files, "cart", seed=1)


def test_a_pose_in_a_corridor_is_uncertain_along_it(tmp_path: Path) -> None:
    with in_a_corridor(tmp_path) as rig:
        where = rig.robot.localization
        assert 0.03 < where.sigma[0] < 0.1
        assert math.sqrt(where.repeatability[1, 1]) < 0.015
        where.set_origin()
        for _ in range(40):
            rig.robot.base.drive(0.5, 0.0)
            rig.robot.step()
        assert where.displacement is not None
        along, across = np.sqrt(np.diag(where.displacement.covariance)[:2]).tolist()
        assert 0.0058 < along < 0.05
        assert across < 0.02


def test_an_arrival_that_is_not_determined_is_no_success(tmp_path: Path) -> None:
    with in_a_corridor(tmp_path) as rig:
        outcome = rig.do(MoveTo(place="ahead"))
    assert isinstance(outcome, Fail | GiveUp)
    assert outcome.reason.startswith("not determined: at ahead the position")


def test_a_place_that_needs_no_more_than_is_known_is_reached(tmp_path: Path) -> None:
    with in_a_corridor(tmp_path, ", tolerance_mm: 500") as rig:
        assert isinstance(rig.do(MoveTo(place="ahead")), Success)


@pytest.mark.parametrize(("along", "across", "right"), [(500, 40, True), (40, 500, False)])
def test_a_tolerance_counts_in_its_own_direction(
    tmp_path: Path, along: int, across: int, right: bool
) -> None:
    """The walls determine the pose across the corridor, the wheels alone along it."""
    with in_a_corridor(tmp_path, f", tolerance_mm: {{along: {along}, across: {across}}}") as rig:
        outcome = rig.do(MoveTo(place="ahead"))
        goal = rig.model.places["ahead"].pose
        truth = rig.backend.ground_truth()
    assert isinstance(outcome, Success) is right
    if right:
        assert truth is not None
        assert abs(truth.base.x - goal.x) < along / 1e3
        assert abs(truth.base.y - goal.y) < across / 1e3
    else:
        assert "at most 40 mm allowed" in getattr(outcome, "reason", "")


def car(sigma_deg: float) -> Any:
    """A car at its place, 6 degrees turned, whose heading is known that well."""
    covariance = np.diag([0.05, 0.05, math.radians(sigma_deg)]) ** 2
    where = SimpleNamespace(map_shift=np.zeros(2), repeatability=covariance, source="Beacons")
    spec = SimpleNamespace(drive=SimpleNamespace(kind="ackermann"))
    return SimpleNamespace(pose=Pose2(0.0, 0.0, math.radians(6.0)), localization=where, spec=spec)


def ended(robot: Any, **place: Any) -> bool:
    """Return whether the effect of MOVE_TO holds."""
    model: Any = SimpleNamespace(places={"here": Place(x_m=0.0, y_m=0.0, heading_deg=0.0, **place)})
    periods = MoveTo(place="here").effect(robot, model)
    with pytest.raises(StopIteration) as end:
        next(periods)
    return bool(end.value.value)


def test_car_arrival_needs_a_determined_heading() -> None:
    """The default is 1.5 m and 20 degrees, with 3 sigma; a place may need more, or less."""
    assert ended(car(2.0))
    with pytest.raises(Discrepancy, match="not determined: at here the heading") as refused:
        ended(car(5.2))
    assert refused.value.measured is not None
    assert refused.value.measured.sensor == "Beacons"
    assert ended(car(5.2), tolerance_deg=30.0)
    with pytest.raises(Discrepancy, match="not determined"):
        ended(car(2.0), tolerance_deg=5.0)


@pytest.mark.parametrize(
    ("std_mm", "std_deg", "right"), [(7.9, 0.1, True), (8.1, 0.1, False), (1.0, 0.4, False)]
)
def test_a_front_determines_the_pose_before_it_or_not(std_mm: float, std_deg: float, right: bool) -> None:
    shelf = {"distance_m": 0.6, "width_m": 0.9, "board_m": 0.4, "front_m": 0.9}
    place = Place.model_validate({"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0, "shelf": shelf})
    front = FrontLine(0.6, 0.0, std_mm / 1e3, math.radians(std_deg), 100)
    if right:
        check_front(front, "shelf", place.need_of("differential"))
        return
    with pytest.raises(Discrepancy, match="not determined: the front before shelf is measured to"):
        check_front(front, "shelf", place.need_of("differential"))


@pytest.mark.parametrize(
    ("off_mm", "std_mm", "drives"),
    [(20.0, 7.0, True), (13.0, 7.0, True), (10.0, 7.0, False), (20.0, 2.0, False), (20.0, 14.0, False)],
)
def test_it_comes_closer_only_where_that_helps(
    monkeypatch: pytest.MonkeyPatch, off_mm: float, std_mm: float, drives: bool
) -> None:
    """The place needs 40 mm: 32 are for the difference and 3 sigma; beyond 40 nothing helps."""
    asked: list[PoseTolerance] = []

    def reach(robot: Any, pose: Pose2, within: PoseTolerance) -> Iterator[None]:
        asked.append(within)
        yield

    monkeypatch.setattr(move_to, "reach_pose", reach)
    monkeypatch.setattr(move_to, "settle", lambda robot: iter(()))
    where = SimpleNamespace(
        map_shift=np.zeros(2), repeatability=np.diag([std_mm / 1e3, std_mm / 1e3, 0.001]) ** 2
    )
    robot: Any = SimpleNamespace(pose=Pose2(off_mm / 1e3, 0.0, 0.0), localization=where)
    place = Place(x_m=0.0, y_m=0.0, heading_deg=0.0, tolerance_mm=40.0)
    list(MoveTo(place="here")._come_closer(robot, place, place.need_of("differential")))
    assert bool(asked) is drives
    if drives:
        assert asked[0].position == pytest.approx(0.5 * (0.040 - 3.0 * std_mm / 1e3))


def test_every_arrival_may_have_to_come_closer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    def come_closer(move: MoveTo, robot: Any, place: Place, need: PoseNeed) -> Iterator[None]:
        asked.append(need.strictest)
        yield

    monkeypatch.setattr(MoveTo, "_come_closer", come_closer)
    with in_a_corridor(tmp_path, ", tolerance_mm: 500") as rig:
        rig.do(MoveTo(place="ahead"))
    assert asked == [0.5]
