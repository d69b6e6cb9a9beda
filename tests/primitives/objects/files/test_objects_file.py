"""Reading a file of objects: everything wrong at once, at its line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.tools.commands.check_file import check_quietly

from ..fetching import TASK, changed, rig_with

CONTRADICTIONS = """\
format: handcart-objects/1
kinds:
  parcel: {size_mm: [60, 90, 80]}
  stone: {size_mm: [60, 90, 80], tags: [{id: 3, side_mm: 70}]}
surfaces:
  table: {x_m: 1.0, y_m: 1.0, height_m: 0.6, size_m: [1.0, 0.5], spots: {left: {x_m: 1.6, y_m: 1.0}}}
  shelf: {x_m: 3.0, y_m: 1.0, height_m: 0.6, size_m: [1.0, 0.5], kinds: [parcels]}
objects:
  one: {kind: parcle, on: table}
  two: {kind: parcel, on: tabel, tags: [{id: 5, side_mm: 40}]}
  three: {kind: parcel, on: table, x_m: 1.0, tags: [{id: 5, side_mm: 40}]}
  four: {kind: parcel, on: table, x_m: 2.0, y_m: 1.0}
  five: {kind: parcel, on: shelf}
"""


def test_contradictions_are_all_reported_at_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "objects.yaml"
    path.write_text(CONTRADICTIONS, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        check_quietly(path)
    found = [(finding.line, finding.column, finding.message) for finding in caught.value.findings]
    messages = {line: [text for other, _, text in found if other == line] for line, _, _ in found}
    assert messages == {
        4: ["the tag 3 is larger than the side +z; allowed: within its side"],
        6: ["the spot 'left' is outside of the surface; allowed: a point on it"],
        7: ["unknown kind 'parcels'; did you mean 'parcel'? allowed: parcel, stone"],
        9: ["unknown kind 'parcle'; did you mean 'parcel'? allowed: parcel, stone"],
        10: ["unknown surface 'tabel'; did you mean 'table'? allowed: table, shelf"],
        11: [
            "only one of x_m and y_m is given; allowed: both, or none for anywhere on the surface",
            "the tag apriltag_36h11 5 is on 'two' and on 'three'; allowed: each tag on one object",
        ],
        12: ["it is believed to be outside of 'table'; allowed: a point on that surface"],
        13: ["the surface 'shelf' takes no parcel; allowed: parcels"],
    }


@pytest.mark.parametrize(
    ("can", "words"),
    [
        ("size_mm: [60, 70, 80]", "a cylinder has one diameter, not 60 and 70 mm"),
        ("size_mm: [60, 60, 80], tags: [{id: 3, side_mm: 45}]", "allowed: on +z of a cylinder, within 42 mm"),
        ("size_mm: [60, 60, 80], tags: [{id: 3, side_mm: 20, face: +x}]", "allowed: on +z of a cylinder"),
    ],
)
def test_cylinder_that_cannot_be_is_reported(can: str, words: str, tmp_path: Path) -> None:
    path = changed(
        tmp_path, "objects.yaml", ("  parcel: {", f"  can: {{shape: cylinder, {can}}}\n  parcel: {{")
    )
    with pytest.raises(FileError, match=re.escape(words)):
        check_quietly(path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("[60, 90, 80]", "[70, 90, 80]", 4, "no side of a parcel is narrow enough for the fingers"),
        ("table_a: {x_m: 2.0,", "table_a: {place: dokc, x_m: 2.0,", 6, "unknown place 'dokc'"),
        ("[1.2, 0.6]}", "[1.2, 1.6]}", 6, "1 of 2 points (objects and spots) are out of reach"),
        ("table_a: {x_m: 2.0, y_m: 3.8", "table_a: {x_m: 2.0, y_m: 8.8", 6, "the base has no room beside"),
    ],
)
def test_unfit_robot_is_refused_before_a_motion(
    tmp_path: Path, old: str, new: str, line: int, words: str
) -> None:
    more = [("x_m: 1.9, y_m: 3.65, ", ""), ("x_m: 2.3, y_m: 3.7, ", "")] if "8.8" in new else []
    objects = changed(tmp_path, "objects.yaml", (old, new), *more)
    with pytest.raises(FileError) as caught:
        _faults(objects)
    assert [(finding.line, words in finding.message) for finding in caught.value.findings] == [(line, True)]


def _faults(objects: Path) -> None:
    rig = rig_with(objects)
    found = list(rig.model.of(Objects).faults(load_robot("librarian")))
    if found:
        raise FileError(found)


def test_base_stands_where_the_arm_reaches_all_work() -> None:
    places = rig_with().model.places
    assert places["table_a"].heading_deg == pytest.approx(90.0)
    assert places["table_b"].heading_deg == pytest.approx(0.0)
    assert places["table_a"].y_m == pytest.approx(3.8 - 0.3 - 0.34 - 0.04)
    assert (places["table_b"].x_m, places["table_b"].y_m) == pytest.approx(
        (5.2 - 0.3 - 0.34 - 0.04 - 0.06, 2.0)
    )


def test_place_by_hand_is_kept(tmp_path: Path) -> None:
    objects = changed(tmp_path, "objects.yaml", ("table_a: {", "table_a: {place: home, "))
    assert "table_a" not in rig_with(objects).model.places


def test_shipped_file_has_no_fault() -> None:
    assert check_quietly(TASK / "objects.yaml") == {"format": "handcart-objects/1"}
