"""Passers in simulated worlds: lidar scans, contacts, checkpoints, findings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.simulation.world_files.load_world import load_world, read_world
from handcart.backends.simulation.world_files.world_findings import world_findings
from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2

WORLD = """\
format: handcart-world/1
start: {x_m: 1, y_m: 1}
walls: [{from_m: [-1, 3], to_m: [9, 3]}]
passers:
"""
CROSSING = "  - {name: anna, waypoints_m: [[3, -2], [3, 2.5]], speed_m_s: 1.0%s}\n"
TOWARDS = "  - {name: bert, body: disc, waypoints_m: [[4, 1], [-2, 1]], speed_m_s: 1.0%s}\n"


@pytest.fixture
def world(tmp_path: Path) -> Any:
    def write(passers: str) -> Path:
        path = tmp_path / "world.yaml"
        path.write_text(WORLD + passers, encoding="utf-8")
        return path

    return write


def build(path: Path, backend: str = "kinematic", seed: int = 0) -> Any:
    spec = load_robot("cart")
    errors = spec.errors.model_copy(update={"start_mm": 0.0, "start_deg": 0.0})
    return make_backend(backend, spec.model_copy(update={"errors": errors}), path, seed)


def step(backend: Any, seconds: float) -> None:
    for _ in range(round(seconds / backend.period)):
        backend.step()


def seen_near(backend: Any, x: float, y: float, radius: float = 0.5) -> np.ndarray:
    """Return the scan's points around a place, on the floor, in [m]."""
    scan = backend.get(RangeSensor).scan()
    points = backend.scene.base.apply(scan.points())
    return np.asarray(points[np.hypot(*(points - (x, y)).T) < radius])


PHYSICS = [pytest.param(name, marks=pytest.mark.slow) for name in ("mujoco", "pybullet")]


@pytest.mark.parametrize("backend", ["kinematic", *PHYSICS])
def test_low_lidar_sees_two_legs_where_the_passer_is(world: Any, backend: str) -> None:
    with build(world(CROSSING % ""), backend) as built:
        step(built, 2.0)
        points = seen_near(built, 3.0, 0.0)
        assert len(points) >= 4
        assert np.hypot(*(points - (3.0, 0.0)).T).max() < 0.35
        step(built, 1.0)
        assert len(seen_near(built, 3.0, 0.0, 0.4)) == 0
        assert len(seen_near(built, 3.0, 1.0)) >= 4


def test_passer_walks_into_a_standing_robot_and_on(world: Any) -> None:
    with build(world(TOWARDS % "")) as built:
        nearest = 10.0
        for _ in range(round(6.0 / built.period)):
            built.step()
            nearest = min(nearest, math.dist(built.scene.passers.steps()[0][2].position, (1.0, 1.0)))
        assert nearest > built.scene.robot.footprint_radius_m + 0.25 - 0.02  # it walks around, not through
        assert [(contact.body, contact.other) for contact in built.scene.contacts] == [("base", "bert")]
        assert built.scene.base[:2] == (1.0, 1.0)


def test_passer_who_yields_stands_before_the_robot(world: Any) -> None:
    with build(world(TOWARDS % ", yields: true, yields_m: 0.5")) as built:
        step(built, 30.0)
        assert built.scene.contacts == []
        x, y = built.scene.passers.steps()[0][2].position
        radius = built.scene.robot.footprint_radius_m
        assert 0.3 < math.hypot(x - 1.0, y - 1.0) - radius - 0.25 < 0.5
        built.scene.move_base(Pose2(1.0, 2.2, 0.0))
        step(built, 3.0)
        assert built.scene.passers.steps()[0][2].position[0] < 0.0


def test_base_that_drives_at_a_passer_stops_at_the_contact(world: Any) -> None:
    with build(world("  - {name: cleo, waypoints_m: [[3, 1]], at_end: stay}\n")) as built:
        for _ in range(round(8.0 / built.period)):
            built.get(Base).drive(0.4, 0.0)
            built.step()
        assert [contact.other for contact in built.scene.contacts] == ["cleo"]
        radius = built.scene.robot.footprint_radius_m
        assert built.scene.base.x == pytest.approx(3.0 - 0.25 - radius, abs=0.01)


def test_same_seed_gives_the_same_walk_from_a_checkpoint(world: Any) -> None:
    path = world(CROSSING % ", speed_sigma_percent: 10" + TOWARDS % ", yields: true")
    with build(path, seed=3) as first, build(path, seed=3) as second, build(path, seed=4) as other:
        step(first, 2.5)
        step(other, 2.5)
        second.set_state(first.state())
        step(first, 2.5)
        step(second, 2.5)
        step(other, 2.5)
        built = first, second, other
        ways = [[item.position.tolist() for _, _, item in b.scene.passers.steps()] for b in built]
        assert ways[0] == ways[1]
        assert ways[0] != ways[2]
        assert np.array_equal(first.get(RangeSensor).scan().ranges, second.get(RangeSensor).scan().ranges)


@pytest.mark.parametrize(
    ("passer", "column", "words"),
    [
        ("{name: a, waypoints_m: [[0, 0], [0, 0]]}", 5, "two waypoints in a row are the same"),
        ("{name: a, waypoints_m: [[0, 0], [1, 0]], pauses_s: [1]}", 5, "1 pauses_s for 2 waypoints_m"),
        ("{name: a, waypoints_m: [[0, 0], [1, 0]], speed_m_s: 9}", 57, "allowed"),
        ("{name: a, waypoints_m: [[0, 0], [1, 0]], at_end: jump}", 54, "turn_back"),
        ("{name: a, waypoint_m: [[0, 0], [1, 0]]}", 15, "waypoints_m"),
        ("{name: a, waypoints_m: [[0, 0]], at_end: loop}", 5, "a loop through one waypoint"),
    ],
)
def test_wrong_passer_is_refused_with_its_place(world: Any, passer: str, column: int, words: str) -> None:
    with pytest.raises(FileError) as refused:
        load_world(world(f"  - {passer}\n"))
    text = str(refused.value)
    assert f"world.yaml:5:{column}:" in text
    assert words in text


def test_two_passers_of_one_name_are_refused(world: Any) -> None:
    with pytest.raises(FileError, match="passers: anna is there twice"):
        load_world(world(CROSSING % "" + CROSSING % ""))


def test_passer_through_a_wall_or_on_the_start_is_found(world: Any) -> None:
    path = world("  - {name: dora, waypoints_m: [[1, 1], [5, 1], [5, 5]]}\n")
    loaded, whole = read_world(path)
    found = [str(finding) for finding in world_findings(loaded, whole, load_robot("cart"), None, None)]
    assert any(":5:40:" in item and "dora walks through wall 1" in item for item in found), found
    assert any("passer dora stands where the robot starts" in item for item in found), found
