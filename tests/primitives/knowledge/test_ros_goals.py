"""Goals as users of nav2 keep them are the places of a map (rows T10, T12)."""

import math
from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.files.models.loading import Loaded
from handcart.primitives.knowledge.place import Places, load_places

STAMPED = """\
- header: {frame_id: map, stamp: {sec: 0, nanosec: 0}}
  name: dock
  pose:
    position: {x: 1.0, y: 2.5, z: 0.0}
    orientation: {x: 0.0, y: 0.0, z: 0.7071068, w: 0.7071068}
- header: {frame_id: map}
  pose:
    position: {x: -3, y: 0, z: 0.0}
    orientation: {x: 0.0, y: 0.0, z: 1.0, w: 0.0}
"""
PANEL = """\
waypoints:
  waypoint0:
    pose: [1.0, 2.5, 0.0]
    orientation: [0.7071068, 0, 0, 0.7071068]
  waypoint1:
    pose: [-3.0, 0.0, 0.0]
    orientation: [0, 0, 0, 1]
"""
ARRAY = """\
header: {frame_id: map}
poses:
  - position: {x: 1.0, y: 2.5, z: 0.0}
    orientation: {x: 0.0, y: 0.0, z: -0.7071068, w: -0.7071068}
  - position: {x: -3, y: 0, z: 0.0}
    orientation: {x: 0.0, y: 0.0, z: 1.0, w: 0.0}
"""
FLAT = "waypoints:\n  - {name: dock, x: 1.0, y: 2.5, yaw: 1.5707963}\n  - {x: -3, y: 0, theta: 3.14159265}\n"


def read(folder: Path, text: str) -> Loaded[Places]:
    (folder / "goals.yaml").write_text(text, encoding="utf-8")
    return load_places(folder / "goals.yaml")


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (STAMPED, ["dock", "goal_2"]),
        ("goals:\n" + "".join(f"  {line}\n" for line in STAMPED.splitlines()), ["dock", "goal_2"]),
        (
            "goals:\n  goals:\n" + "".join(f"    {line}\n" for line in STAMPED.splitlines()),
            ["dock", "goal_2"],
        ),
        (PANEL, ["waypoint0", "waypoint1"]),
        (ARRAY, ["goal_1", "goal_2"]),
        (FLAT, ["dock", "goal_2"]),
    ],
)
def test_each_way_to_write_two_goals(tmp_path: Path, text: str, names: list[str]) -> None:
    places = read(tmp_path, text).value.places
    assert list(places) == names
    first, second = places.values()
    assert (first.x_m, first.y_m) == (1.0, 2.5)
    assert first.heading_deg == pytest.approx(90.0, abs=1e-4)
    assert (second.x_m, second.y_m) == (-3.0, 0.0)
    assert abs(second.heading_deg) == pytest.approx(180.0, abs=1e-4)


def test_places_are_read_as_before(tmp_path: Path) -> None:
    text = "format: handcart-places/1\nplaces:\n  home: {x_m: 1.0, y_m: 5.2, heading_deg: 0.0}\n"
    assert read(tmp_path, text).value.places["home"].pose == (1.0, 5.2, 0.0)


def test_what_is_wrong_with_a_place_is_told_where_the_goal_stands(tmp_path: Path) -> None:
    loaded = read(tmp_path, STAMPED)
    assert str(loaded.finding(("places", "goal_2"), "no")).endswith("goals.yaml:6:3: no")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "frame_id: map, stamp",
            "frame_id: odom, stamp",
            "1:22: the goal is in the frame 'odom'; allowed: map",
        ),
        (
            "z: 0.7071068, w: 0.7071068",
            "z: 0.0, w: 0.0",
            "5:18: the orientation is a quaternion of length 0; allowed: 1",
        ),
        ("z: 0.7071068, w: 0.7071068", "z: 0.0", "5:18: the goal has no number 'w' here"),
        (
            "{x: 0.0, y: 0.0, z: 0.7071068",
            "{x: 0.7071068, y: 0.0, z: 0.0",
            "5:18: the goal is tilted by 90 deg",
        ),
        ("x: 1.0, y: 2.5", "x: 1.0, y: far", "4:27: the goal has no number 'y' here; needed: y of its pose"),
        ("name: dock", "name: goal_2", "6:3: the goal 'goal_2' is there twice; allowed: each name once"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in STAMPED
    with pytest.raises(FileError) as error:
        read(tmp_path, STAMPED.replace(old, new))
    assert f"goals.yaml:{words}" in str(error.value)


@pytest.mark.parametrize("text", ["[]\n", "waypoints: []\n", "poses: 3\n", "goals: {a: {}}\n", "[[1, 2]]\n"])
def test_a_file_without_goals_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(FileError, match=r"allowed|needed"):
        read(tmp_path, text)


def test_every_heading_comes_back(tmp_path: Path) -> None:
    for degrees in range(-179, 181, 13):
        half = math.radians(degrees) / 2
        turn = f"{{x: 0, y: 0, z: {math.sin(half)}, w: {math.cos(half)}}}"
        text = f"- {{position: {{x: 0, y: 0}}, orientation: {turn}}}\n"
        place = read(tmp_path, text).value.places["goal_1"]
        assert math.remainder(place.heading_deg - degrees, 360.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("under", ["", "goals:\n"])
def test_goals_may_be_lists_by_name(tmp_path: Path, under: str) -> None:
    path = tmp_path / "goals.yaml"
    lines = ["dock: [1.0, 2.5, 1.5707963]", "desk: [-3, 0, 0]"]
    path.write_text(under + "".join(f"{'  ' if under else ''}{line}\n" for line in lines), encoding="utf-8")
    places = load_places(path).value.places
    assert [(place.x_m, place.y_m) for place in places.values()] == [(1.0, 2.5), (-3.0, 0.0)]
    assert places["dock"].heading_deg == pytest.approx(90.0, abs=1e-4)


def test_goal_list_of_another_length_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "goals.yaml"
    path.write_text("dock: [1.0, 2.5]\ndesk: [-3, 0, 0, 1]\n", encoding="utf-8")
    with pytest.raises(FileError) as error:
        load_places(path)
    assert [found.message for found in error.value.findings] == [
        "the goal has 2 numbers; allowed: [x, y, theta]",
        "the goal has 4 numbers; allowed: [x, y, theta]",
    ]
