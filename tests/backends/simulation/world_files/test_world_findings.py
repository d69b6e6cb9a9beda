"""Faults that would spoil a run are found before it begins (row T12)."""

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import check_world
from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.0, heading_deg: 90.0}
walls:
  - {from_m: [0.0, 0.0], to_m: [4.0, 0.0]}
  - {from_m: [4.0, 0.0], to_m: [4.0, 3.0]}
furniture:
  - {name: desk, x_m: 3.0, y_m: 2.0, size_m: [0.6, 0.6, 0.7]}
"""
HOME = Pose2(1.0, 1.0, np.pi / 2)
LIBRARIAN = load_robot("librarian")


def room(dx: float = 0.0) -> GridMap:
    """The map of the room, or of one that lies `dx` further east."""
    walls = [(2.0 + dx, 0.0, 0.0, 4.1, 0.1), (4.0 + dx, 1.5, 0.0, 0.1, 3.1), (3.0 + dx, 2.0, 0.0, 0.6, 0.6)]
    return from_boxes(walls, 0.05, (-1.0 + min(dx, 0.0), -1.0), (6.0 + abs(dx), 5.0))


def findings(
    folder: Path,
    *changes: tuple[str, str],
    start: Pose2 | None = HOME,
    grid: GridMap | None = None,
    robot: RobotFile = LIBRARIAN,
) -> str:
    text = WORLD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "world.yaml").write_text(text, encoding="utf-8")
    try:
        check_world(folder / "world.yaml", robot, start, room() if grid is None else grid)
    except FileError as error:
        return str(error)
    return ""


def test_a_world_as_it_is_told_is_good(tmp_path: Path) -> None:
    assert findings(tmp_path) == ""
    assert findings(tmp_path, start=None) == ""


@pytest.mark.parametrize(
    "thing",
    [
        "furniture:\n  - {name: box, x_m: 1.2, y_m: 1.0, size_m: [0.2, 0.2, 0.2]}",
        "surprises: [{name: box, x_m: 1.4, y_m: 1.0, size_m: [0.2, 0.2, 0.2], leaves_s: 5.0}]\nfurniture:",
        "tables: [{name: box, x_m: 1.0, y_m: 0.8, size_m: [0.9, 0.9, 0.3], foot_m: [0.1, 0.1]}]\nfurniture:",
    ],
)
def test_what_stands_where_the_robot_starts_is_told(tmp_path: Path, thing: str) -> None:
    found = findings(tmp_path, ("furniture:", thing))
    assert "world.yaml:2:8: " in found
    assert "box stands where the robot starts" in found
    assert f"allowed: beyond its footprint, {LIBRARIAN.footprint_radius_m:.2f} m" in found


@pytest.mark.parametrize(
    "thing",
    [
        "furniture:\n  - {name: lamp, x_m: 1.2, y_m: 1.0, size_m: [0.2, 0.2, 0.2], above_m: 2.5}",
        "surprises: [{name: box, x_m: 1.0, y_m: 1.0, size_m: [0.2, 0.2, 0.2], appears_s: 5.0}]\nfurniture:",
    ],
)
def test_what_hangs_above_or_comes_later_is_none(tmp_path: Path, thing: str) -> None:
    assert findings(tmp_path, ("furniture:", thing)) == ""


def test_a_robot_that_is_put_elsewhere_than_it_is_told_is_told(tmp_path: Path) -> None:
    found = findings(tmp_path, start=Pose2(2.0, 1.0, np.pi / 2))
    assert (
        "world.yaml:2:8: the robot is put 1.00 m and 0 deg from where it is told to start, (2.00, 1.00)"
        in found
    )
    assert "put 0.00 m and 90 deg" in findings(tmp_path, ("heading_deg: 90.0", "heading_deg: -180.0"))
    assert findings(tmp_path, ("heading_deg: 90.0", "heading_deg: -270.0")) == ""


def test_a_robot_that_is_misplaced_on_purpose_is_accepted(tmp_path: Path) -> None:
    swap = ("furniture:", "misplaced: true\nfurniture:")
    assert findings(tmp_path, swap, start=Pose2(2.0, 1.0, np.pi / 2)) == ""


def test_a_world_off_its_map_is_told(tmp_path: Path) -> None:
    assert "the robot starts off the map" in findings(tmp_path, ("x_m: 1.0", "x_m: -3.0"), start=None)
    found = findings(tmp_path, grid=room(-2.0))
    assert "world.yaml:1:1: only" in found
    assert "allowed: 50% at least" in found


def test_a_moved_beacon_that_the_robot_does_not_hear_is_found(tmp_path: Path) -> None:
    moved = ("furniture:", "beacons:\n  places_m: {south: [0, 1, 2], nrth: [1, 2, 3]}\nfurniture:")
    beacons = BeaconsSpec(places_m={"north": (0.0, 0.0, 2.0), "south": (9.0, 0.0, 2.0)})
    robot = LIBRARIAN.model_copy(update={"beacons": beacons})
    found = findings(tmp_path, moved, robot=robot)
    assert "world.yaml:7:32: unknown beacon 'nrth'; did you mean 'north'? allowed: north, south" in found
    assert "'south'; " not in found
    assert findings(tmp_path, (moved[0], moved[1].replace("nrth", "north")), robot=robot) == ""
    assert findings(tmp_path, moved) == ""  # a robot without beacons, in the same world


def test_an_outage_that_ends_before_it_begins_is_found(tmp_path: Path) -> None:
    sky = ("furniture:", "sky: {outages: [{from_s: 60, to_s: 30}]}\nfurniture:")
    assert "the outage ends before it begins; allowed: to_s later than from_s" in findings(tmp_path, sky)
    assert findings(tmp_path, (sky[0], sky[1].replace("30", "90"))) == ""
