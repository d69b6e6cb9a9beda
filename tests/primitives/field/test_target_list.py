"""Lists of targets, as a user gives them."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import pytest

from benchmarks.field.field_course import zigzag_course
from handcart.backends.robot.localization.determination import PoseNeed
from handcart.files.errors import FileError
from handcart.primitives.field.field import Field, Origin
from handcart.primitives.field.target import Target
from handcart.primitives.field.target_list import load_targets, place_of
from handcart.robotics.geometry.pose2 import Pose2

START = Pose2(0.0, 0.0, 0.0)
FIELD = Field(
    format="handcart-field/1",
    x_m=(-20.0, 100.0),
    y_m=(-40.0, 60.0),
    origin=Origin(latitude_deg=38.2545, longitude_deg=140.85),
)


def read(tmp_path: Path, text: str, name: str = "targets.csv", field: Field = FIELD) -> dict[str, Target]:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return load_targets(path, field, START)


def faults(
    tmp_path: Path, text: str, name: str = "targets.csv", field: Field = FIELD
) -> list[tuple[int, int, str]]:
    with pytest.raises(FileError) as error:
        read(tmp_path, text, name, field)
    return [(finding.line, finding.column, finding.message) for finding in error.value.findings]


def test_the_base_stands_where_the_course_has_it(tmp_path: Path) -> None:
    course = zigzag_course()
    rows = "".join(f"{n},{x!r},{y!r}\n" for n, (x, y) in enumerate(course.targets.tolist()))
    targets = read(tmp_path, "name,x_m,y_m\n" + rows)
    stops = course.line[course.stops]
    for target, stop in zip(targets.values(), stops, strict=True):
        assert math.dist(target.stand[:2], stop) < 1e-6


def test_a_heading_is_taken_over(tmp_path: Path) -> None:
    target = read(tmp_path, "name,x_m,y_m,heading_deg\na,10,0,90\n")["a"]
    assert target.stand == pytest.approx((9.25, 0.0, math.pi / 2))


def test_degrees_in_csv_and_geojson_are_the_same_place(tmp_path: Path) -> None:
    by_csv = read(tmp_path, "name,latitude_deg,longitude_deg\na,38.2546,140.8503\n")["a"]
    point = {"type": "Point", "coordinates": [140.8503, 38.2546]}
    feature = {"type": "Feature", "geometry": point, "properties": {"name": "a"}}
    text = json.dumps({"type": "FeatureCollection", "features": [feature]})
    assert read(tmp_path, text, "targets.geojson")["a"][:3] == by_csv[:3]
    # A minute of arc of the meridian is a sea mile; here 0.0001 deg are 11.1 m.
    assert by_csv.y == pytest.approx(11.1, abs=0.05)
    assert by_csv.x == pytest.approx(0.0003 * 111_320 * math.cos(math.radians(38.2545)), abs=0.1)


def test_each_bad_line_is_told(tmp_path: Path) -> None:
    text = "name,x_m,y_m\na,10,0\na,20,0\nb,nan,0\nc,10.1,0\nd,500,0\ne,ten,0\nf,1\n"
    found = faults(tmp_path, text)
    assert [line for line, _, _ in found] == [3, 4, 5, 6, 7, 8]
    words = [message for _, _, message in found]
    for wrong, part in zip(words, ["twice", "finite", "apart", "outside", "ten", "cells"], strict=True):
        assert part in wrong
        assert "allowed" in wrong
    assert found[1][1] == 3  # the cell of x


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ("-38.2546,140.8503", "latitude_deg has the wrong sign (hemisphere)"),
        ("38.2546,-140.8503", "longitude_deg has the wrong sign (hemisphere)"),
        ("-38.2546,-140.8503", "both have the wrong sign (hemisphere)"),
        ("98.0,140.8503", "allowed: -90 to 90"),
        ("39.0,140.8503", "outside"),
    ],
)
def test_degrees_elsewhere_are_refused(tmp_path: Path, place: str, expected: str) -> None:
    ((line, _, message),) = faults(tmp_path, f"name,latitude_deg,longitude_deg\na,{place}\n")
    assert line == 2
    assert expected in message


def test_degrees_need_an_origin(tmp_path: Path) -> None:
    field = FIELD.model_copy(update={"origin": None})
    ((_, _, message),) = faults(tmp_path, "name,latitude_deg,longitude_deg\na,38.2,140.8\n", field=field)
    assert "origin" in message


def geojson(*properties: dict[str, object], indent: int | None = None) -> str:
    """Return points in a row, a metre from each other, with the given properties."""
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [140.85 + 1e-5 * number, 38.2545]},
            "properties": given,
        }
        for number, given in enumerate(properties)
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=indent)


@pytest.mark.parametrize("indent", [None, 1])
def test_geojson_of_as_many_points_as_allowed_is_read(tmp_path: Path, indent: int | None) -> None:
    """Libraries write it in one line, and maps' editors add properties."""
    wide = FIELD.model_copy(update={"x_m": (-20.0, 6000.0)})
    points = [{"name": f"p{number}", "fid": number, "elevation": 1.5} for number in range(5000)]
    found = read(tmp_path, geojson(*points, indent=indent), "t.geojson", wide)
    assert list(found) == [f"p{number}" for number in range(5000)]


def test_properties_of_geojson_are_those_of_a_table(tmp_path: Path) -> None:
    """Editors write null for what is not filled in."""
    text = geojson({"name": None}, {"name": None, "heading_deg": None}, {"name": "c", "heading_deg": 90})
    found = read(tmp_path, text, "t.geojson")
    assert list(found) == ["1", "2", "c"]
    assert found["c"].stand.theta == pytest.approx(math.pi / 2)
    wrong = faults(tmp_path, geojson({"heading_deg": "north"}), "t.geojson")
    assert "heading_deg is 'north'; allowed: a finite number" in wrong[0][2]


@pytest.mark.parametrize("text", ["", "name,x\n", "name,x_m,y_m\n", "name,x_m,y_m,latitude_deg\na,1,1,1\n"])
def test_a_list_without_targets_is_refused(tmp_path: Path, text: str) -> None:
    assert faults(tmp_path, text)


@pytest.mark.parametrize(
    "text",
    [
        "{}",
        '{"type": "FeatureCollection", "features": []}',
        '{"features": [{"geometry": {"type": "LineString", "coordinates": [[1, 2], [2, 3]]}}]}',
    ],
)
def test_geojson_without_points_is_refused(tmp_path: Path, text: str) -> None:
    assert faults(tmp_path, text, "targets.geojson")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("name,x_m,y_m\n" + "a" * 200_000 + ",1,2\n", 2, "a line of more than 20000 characters"),
        ("name,x_m,y_m\n" + "a" * 61 + ",1,2\n", 2, "the name has 61 characters; allowed: 60"),
        ('name,x_m,y_m\n"a' + ",1,2\n" * 40_000, 26216, "invalid CSV: field larger than field limit"),
        ("name,x_m,y_m\n" + "\n" * 5001, 5002, "more than 5000 rows; allowed: fewer"),
        ("name,x_m,y_m\na,1_0,2\n", 2, "x_m is '1_0'; allowed: a finite number"),
        ("name,x_m,y_m\na,1\0,2\n", 2, "the character U+0000"),
        ("x" * 19_000 + "\n", 1, "the header is 'xxxx"),
    ],
)
def test_a_list_as_strangers_write_it_is_refused_at_its_line(
    tmp_path: Path, text: str, line: int, words: str
) -> None:
    """T2, T14"""
    messages = faults(tmp_path, text)
    assert [item for item, _, _ in messages] == [line]
    assert words in messages[0][2]
    assert len(messages[0][2]) < 300


def test_a_list_of_40_mb_is_not_read(tmp_path: Path) -> None:
    """T2"""
    path = tmp_path / "targets.csv"
    path.touch()
    os.truncate(path, 40_000_000)
    with pytest.raises(FileError, match=r"targets.csv:1:1: the file has 40000000 bytes; allowed: at most"):
        load_targets(path, FIELD, START)


def test_a_list_from_a_spreadsheet_begins_with_a_byte_order_mark(tmp_path: Path) -> None:
    assert read(tmp_path, "\ufeffname, x_m, y_m\na, 10, 0\n")["a"].x == 10.0


def test_the_largest_list_is_read_and_one_target_too_near_is_found(tmp_path: Path) -> None:
    apart = [(x, y) for x in range(-19, 81) for y in range(-25, 25)]
    rows = [f"t{number},{x},{y}" for number, (x, y) in enumerate(apart[:-1])]
    last = f"last,{apart[0][0] + 0.2},{apart[0][1] - 0.2}"
    ((line, _, message),) = faults(tmp_path, "\n".join(["name,x_m,y_m", *rows, last]))
    assert (line, "lies where t0 does" in message) == (5001, True)


def test_a_stand_is_needed_as_exactly_as_the_field_says(tmp_path: Path) -> None:
    target = read(tmp_path, "name,x_m,y_m,heading_deg\na,10,5,30\n")["a"]
    usual = place_of(target, FIELD).need_of("ackermann")
    assert usual == PoseNeed(1.5, math.radians(20.0))
    words = {"stand_tolerance_mm": {"along": 1000, "across": 850}, "stand_tolerance_deg": 12}
    field = Field.model_validate(FIELD.model_dump() | words)
    need = place_of(target, field).need_of("ackermann")
    assert need == pytest.approx(PoseNeed(1.0, math.radians(12.0), 0.85, math.radians(30.0)))
