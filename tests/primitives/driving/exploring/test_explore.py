"""EXPLORE: a robot that is given nothing draws the map of its world, or comes back to where it began."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from benchmarks.driving.cluttered_robot import write_robot
from handcart.evaluation.judging.map_survey import MapFigures, compare_with_world
from handcart.evaluation.judging.survey import SurveyedRun, simulated_world
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.exploring import explore
from handcart.primitives.driving.exploring.explore import Explore
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2

START = {"x_m": 1.5, "y_m": 1.2, "heading_deg": 40.0}
ROOM = [([0, 0], [4, 0]), ([4, 0], [4, 3]), ([4, 3], [0, 3]), ([0, 3], [0, 0])]
TWO_ROOMS = [
    ([0, 0], [7, 0]),
    ([7, 0], [7, 4]),
    ([7, 4], [0, 4]),
    ([0, 4], [0, 0]),
    ([3.5, 0], [3.5, 2.5]),
    ([3.5, 3.7], [3.5, 4]),
]


def world(folder: Path, walls: list[Any], **more: Any) -> RigFiles:
    path = folder / "world.yaml"
    content = {
        "format": "handcart-world/1",
        "start": START,
        "walls": [{"from_m": begin, "to_m": end} for begin, end in walls],
        **more,
    }
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return RigFiles.without_map(path)


def truth_of(rig: Rig) -> Pose2:
    truth = rig.backend.ground_truth()
    assert truth is not None
    return truth.base


def figures(rig: Rig, made: Explore) -> MapFigures:
    run = SurveyedRun(rig.robot, rig.robot.spec, rig.model, simulated_world(rig.backend))
    return compare_with_world(run, made.evidence.maps["explored"], made.radius_m)


@pytest.mark.slow
def test_explore_goes_through_a_door_and_maps_both_rooms(tmp_path: Path) -> None:
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        made = Explore()
        assert isinstance(rig.do(made), Success), made.facts
        found = figures(rig, made)
        assert found.mapped_percent > 99.0
        assert np.median(found.walls_mm) < 30.0
        assert np.quantile(found.walls_mm, 0.95) < 80.0
        start = Pose2(1.5, 1.2, np.radians(40.0))
        assert start.compose(rig.robot.pose).distance(truth_of(rig)) < 0.03
        assert "narrower than the robot" in str(made.facts["unknown_border"])
        assert made.evidence.pictures["map"].ndim == 3
        assert len(rig.model.sensed_cells) > 100


def test_explore_leaves_what_is_beyond_its_radius(tmp_path: Path) -> None:
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        made = Explore(radius_m=1.5)
        assert isinstance(rig.do(made), Success)
        assert truth_of(rig).x < 3.0
        assert "beyond radius_m" in str(made.facts["unknown_border"])


@pytest.mark.slow
def test_explore_without_way_left_comes_back(tmp_path: Path) -> None:
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        begun, made = truth_of(rig), Explore(longest_m=1.0)
        failed = rig.do(made)
        assert isinstance(failed, Fail)
        assert failed.permanent
        assert "frontiers are left after 1 m" in failed.reason
        assert rig.robot.localization.travel.left > 1.0
        assert truth_of(rig).distance(begun) < 0.02
        assert "explored" in made.evidence.maps


def test_exploration_with_goals_that_change_all_the_time_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each look finds another goal before the base has begun to drive to the last one."""
    monkeypatch.setattr(explore, "STANDING_TIMEOUT_S", 5.0)
    monkeypatch.setattr(explore, "LOOK_PERIOD_S", 0.0)
    monkeypatch.setattr(Explore, "_goes_on", lambda *_: False)
    with build_rig(world(tmp_path, TWO_ROOMS), robot="cart") as rig:
        begun = rig.robot.time
        failed = rig.do(Explore(wait_s=1.0))
        assert isinstance(failed, Fail)
        assert failed.reason == "the base doesn't get on to any frontier"
        assert failed.cause is causes.NO_PROGRESS
        assert rig.robot.time < begun + 60.0


@pytest.mark.parametrize("robot", ["cart", "toyama"])
@pytest.mark.slow
def test_cancelled_exploration_is_restored(robot: str, tmp_path: Path) -> None:
    """The start is found again by scans, with both localizers."""
    from handcart.primitives.contract.attempt import attempt

    with build_rig(world(tmp_path, TWO_ROOMS), robot=robot) as rig:
        begun = truth_of(rig)
        periods = attempt(Explore(), rig.robot, rig.model)
        while truth_of(rig).x < 3.0:
            next(periods)
            rig.robot.step()
        periods.throw(Discrepancy("cancelled by request", cause=causes.CANCELLED))
        with pytest.raises(StopIteration) as end:
            while True:
                rig.robot.step()
                next(periods)
        assert isinstance(end.value.value, Fail), end.value.value
        assert truth_of(rig).distance(begun) < 0.025


@pytest.mark.slow
@pytest.mark.parametrize(("view_deg", "sides"), [(90.0, (0.22,)), (270.0, (0.5, 0.43))])
def test_lidar_that_does_not_see_all_around_maps_it_all(
    view_deg: float, sides: tuple[float, ...], tmp_path: Path
) -> None:
    """It turns on the spot first: no route begins on ground that was not seen."""
    path = write_robot(tmp_path, sides, 0.6, "scan", view_deg)
    with build_rig(world(tmp_path, TWO_ROOMS), robot=str(path)) as rig:
        made = Explore()
        assert isinstance(rig.do(made), Success), made.facts
        assert figures(rig, made).mapped_percent > 98.0


@pytest.mark.slow
def test_partial_map_is_completed_in_its_frame(tmp_path: Path) -> None:
    """The map shows one of two rooms, and the robot starts 20 mm beside its start."""
    from handcart.files.maps.map_writing import write_grid
    from handcart.robotics.navigation.maps.grid_map import from_boxes

    files = world(tmp_path, TWO_ROOMS)
    half = [(0.0, 2.0, 0.0, 0.1, 4.0), (1.75, 0.0, 0.0, 3.5, 0.1), (1.75, 4.0, 0.0, 3.5, 0.1)]
    half += [(3.5, 1.25, 0.0, 0.1, 2.5), (3.5, 3.85, 0.0, 0.1, 0.3)]
    grid = from_boxes(half, 0.05, (-0.2, -0.2), (3.7, 4.4))
    write_grid(tmp_path / "map.yaml", grid)
    place = "{x_m: 1.5, y_m: 1.2, heading_deg: 40}"
    (tmp_path / "places.yaml").write_text(f"format: handcart-places/1\nplaces: {{here: {place}}}\n")
    known = RigFiles(files.world, tmp_path / "map.yaml", tmp_path / "places.yaml", {}, "here")
    with build_rig(known, robot="cart") as rig:
        made = Explore()
        assert isinstance(rig.do(made), Success), made.facts
        found = figures(rig, made)
        assert found.mapped_percent > 99.0
        assert np.quantile(found.walls_mm, 0.95) < 80.0
        assert rig.robot.pose.distance(truth_of(rig)) < 0.04


def test_lidar_that_repeats_its_scan_ends_the_drive(tmp_path: Path) -> None:
    with build_rig(world(tmp_path, TWO_ROOMS), robot="toyama") as rig:
        lidar = rig.robot.lidar
        assert lidar is not None
        made, first = Explore(), lidar.scan()
        lidar.scan = lambda: first  # type: ignore[method-assign]
        ended = rig.do(made)
        assert isinstance(ended, GiveUp)
        assert "the lidar repeats its" in ended.reason


def test_car_does_not_explore(tmp_path: Path) -> None:
    with build_rig(world(tmp_path, ROOM), robot="el_verde") as rig:
        assert "car-like" in Explore().unmet_precondition(rig.robot, rig.model.view(Explore()))  # type: ignore[arg-type]
