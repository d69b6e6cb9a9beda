"""The map tools on a small drawn map: crop, turn, keepout, compare, walls."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.files.maps.map_file import load_map
from handcart.files.maps.map_writing import write_grid
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.map_comparison import compare_maps
from handcart.robotics.navigation.mapping.map_editing import straightening_angle, turn
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

Handcart = Callable[..., Any]
BOXES = [(3.0, 0.0, 0.0, 6.0, 0.1), (3.0, 4.0, 0.0, 6.0, 0.1), (0.0, 2.0, 0.0, 0.1, 4.0)]
BOXES += [(6.0, 2.0, 0.0, 0.1, 4.0), (1.5, 1.0, 0.0, 0.8, 0.4), (4.5, 2.8, 0.0, 0.3, 1.0)]
WORLD = """
format: handcart-world/1
start: {x_m: 3, y_m: 2}
walls:
  - {from_m: [0, 0], to_m: [6, 0]}
  - {from_m: [0, 4], to_m: [6, 4]}
  - {from_m: [0, 0], to_m: [0, 4]}
  - {from_m: [6, 0], to_m: [6, 4]}
furniture:
  - {name: table, x_m: 1.5, y_m: 1.0, size_m: [0.8, 0.4, 0.7]}
  - {name: shelf, x_m: 4.5, y_m: 2.8, size_m: [0.3, 1.0, 2.0]}
  - {name: sofa, x_m: 3.0, y_m: 1.5, size_m: [0.5, 0.5, 0.7]}
"""


def room(resolution: float = 0.05) -> GridMap:
    return from_boxes(BOXES, resolution, (-1.0, -1.0), (8.0, 6.0))


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    write_grid(tmp_path / "plan.yaml", room())
    return tmp_path / "plan.yaml"


def test_written_map_is_read_back_the_same(plan: Path) -> None:
    grid, warning = load_map(plan)
    assert warning is None
    assert (grid.occupied == room().occupied).all()
    assert not grid.unknown.any()
    assert (plan.parent / "plan.pgm").read_bytes().startswith(b"P5")


@pytest.mark.parametrize("name", ["lab #2", "yes", "- x", 'the "lab"', "it's"])
def test_a_map_may_have_any_name(tmp_path: Path, name: str) -> None:
    write_grid(tmp_path / f"{name}.yaml", room())
    grid, _ = load_map(tmp_path / f"{name}.yaml")
    assert (grid.occupied == room().occupied).all()


def test_cropped_map_keeps_each_cell_at_its_place(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    assert handcart("map", "crop", plan, "-o", tmp_path / "new.yaml", "--box", "1,0.5,5,3").status == 0
    part, _ = load_map(tmp_path / "new.yaml")
    assert part.occupied.shape == (50, 80)
    walls = part.to_point(np.argwhere(part.occupied))
    cells = room().to_cell(walls)
    assert len(walls) > 100
    assert room().occupied[cells[:, 0], cells[:, 1]].all()
    assert np.allclose(walls, room().to_point(cells))


def test_crop_without_a_box_cuts_unknown_edges(tmp_path: Path, handcart: Handcart) -> None:
    grid = room()
    unknown = np.ones_like(grid.occupied)
    unknown[40:80, 30:90] = False
    write_grid(tmp_path / "a.yaml", grid._replace(occupied=grid.occupied & ~unknown, unknown=unknown))
    assert handcart("map", "crop", tmp_path / "a.yaml", "-o", tmp_path / "b.yaml").status == 0
    assert load_map(tmp_path / "b.yaml")[0].occupied.shape == (50, 70)


@pytest.mark.parametrize("angle", [-40.0, -11.3, -0.7, 0.0, 4.0, 27.9, 44.0])
def test_turned_map_is_straightened_again(angle: float) -> None:
    turned = turn(room(0.04), math.radians(angle))
    assert math.degrees(straightening_angle(turned)) == pytest.approx(-angle, abs=0.3)


@pytest.mark.parametrize(("degrees", "x", "y"), [(0.0, 0.0, 0.0), (170.0, -12.0, 5.0), (-33.0, 3.3, 8.0)])
def test_compared_maps_are_aligned_from_anywhere(degrees: float, x: float, y: float) -> None:
    moved = turn(room(), math.radians(degrees))
    moved = moved._replace(origin_x=moved.origin_x + x, origin_y=moved.origin_y + y)
    found = compare_maps(room(), moved)
    expected = Pose2(x, y, math.radians(degrees)).inverse()
    assert found.first_T_second.distance(expected) < 0.05 * (1.0 + math.hypot(x, y) * 0.2)
    assert found.first_T_second.turn(expected) < math.radians(0.5)
    assert found.figures(found.first)[0] < 0.03


def test_turn_of_90_degrees_moves_the_corner(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    assert handcart("map", "turn", plan, "-o", tmp_path / "new.yaml", "--deg", "90").status == 0
    turned, _ = load_map(tmp_path / "new.yaml")
    at = turned.to_cell(np.array([[-1.0, 1.5]]))[0]  # the table's middle
    assert turned.occupied[tuple(at)]
    assert turned.occupied.sum() == room().occupied.sum()


def test_keepout_zones_are_added_and_removed(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    zones = tmp_path / "zones.yaml"
    square = "1,1,3,1,3,3,1,3"
    assert handcart("map", "keepout", plan, "-o", zones, "--add", square).status == 0
    grid, _ = load_map(zones)
    assert grid.occupied.sum() * 0.05**2 == pytest.approx(4.0, abs=0.3)
    assert grid.occupied[tuple(grid.to_cell(np.array([[2.0, 2.0]]))[0])]
    assert handcart("map", "keepout", plan, "-o", zones, "--remove", "0,0,2,0,2,4,0,4").status == 0
    less, _ = load_map(zones)
    assert less.occupied.sum() * 0.05**2 == pytest.approx(2.0, abs=0.3)
    assert not less.occupied[tuple(grid.to_cell(np.array([[1.5, 2.0]]))[0])]


def test_comparison_reports_what_is_missing(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    write_grid(tmp_path / "less.yaml", from_boxes(BOXES[:-1], 0.05, (-1.0, -1.0), (8.0, 6.0)))
    said = handcart("map", "compare", plan, tmp_path / "less.yaml", "--json", "-o", tmp_path / "a.svg")
    found = json.loads(said.out)
    assert math.hypot(found["x_m"], found["y_m"]) < 0.01
    assert found["walls"][0]["missing_in_other"] > 0.02
    assert found["walls"][1]["missing_in_other"] == 0.0
    assert found["walls"][1]["median_m"] < 0.005
    assert "<svg" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_compared_maps_of_one_name_get_distinct_names(tmp_path: Path, handcart: Handcart) -> None:
    for folder in ("office", "other"):
        (tmp_path / folder).mkdir()
        write_grid(tmp_path / folder / "map.yaml", room())
    said = handcart(
        "map", "compare", tmp_path / "office" / "map.yaml", tmp_path / "other" / "map.yaml", "--keep"
    )
    assert "the frame of other/map.yaml is at" in said.out
    assert "walls of office/map.yaml: median 0.0 cm" in said.out


def test_world_walls_report_things_that_a_map_lacks(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    (tmp_path / "world.yaml").write_text(WORLD, encoding="utf-8")
    said = handcart("map", "walls", plan, tmp_path / "world.yaml", "--json")
    found = json.loads(said.out)
    assert [item["name"] for item in found["lacking"]] == ["sofa"]
    assert found["lacking"][0]["missing"] > 0.9
    assert found["p95_m"] < 0.05
    assert "sofa: " in handcart("map", "walls", plan, tmp_path / "world.yaml").out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["crop", "PLAN", "-o", "NEW", "--box", "1,2,3"], "allowed: 4 numbers, with commas between"),
        (["crop", "PLAN", "-o", "NEW", "--box", "90,90,95,95"], "nothing of the map is left"),
        (["crop", "PLAN", "-o", "NEW", "--box", "nan,0,1,1"], "allowed: 4 numbers"),
        (["crop", "PLAN", "-o", "PLAN"], "it is the map that is read"),
        (["crop", "PLAN", "-o", "new.png"], "allowed: a name that ends in .yaml"),
        (["turn", "none.yaml", "-o", "NEW"], "none.yaml:1:1: the file does not exist"),
        (["keepout", "PLAN", "-o", "NEW"], "nothing to do; allowed: --add or --remove"),
        (["keepout", "PLAN", "-o", "NEW", "--add", "0,0,1,1"], "at least three corners"),
        (["keepout", "PLAN", "-o", "NEW", "--add", "90,90,91,90,91,91"], "no cell changes"),
        (["compare", "PLAN", "PLAN", "-o", "a.txt"], "unknown suffix '.txt' of a picture"),
        (["walls", "PLAN", "PLAN"], "PLAN:1:1"),
    ],
)
def test_bad_words_for_a_map_tool_are_refused(
    plan: Path, tmp_path: Path, handcart: Handcart, words: list[str], said: str
) -> None:
    named = {"PLAN": str(plan), "NEW": str(tmp_path / "new.yaml")}
    found = handcart("map", *(named.get(word, word) for word in words))
    assert found.status == 2
    error = "".join(found.err.replace("│", "").split())
    assert "".join(said.replace("PLAN", str(plan)).split()) in error, found.err
    assert "Traceback" not in found.err
    assert not (tmp_path / "new.yaml").exists()


def test_walls_at_unknown_places_are_not_compared(plan: Path, tmp_path: Path, handcart: Handcart) -> None:
    grid, columns = room(), np.arange(room().occupied.shape[1])
    for name, known in (("left", columns < 20), ("right", columns >= 60)):
        half = grid._replace(occupied=grid.occupied & known, unknown=grid.unknown | ~known)
        write_grid(tmp_path / f"{name}.yaml", half)
    maps = ("map", "compare", tmp_path / "left.yaml", tmp_path / "right.yaml", "--keep")
    figures = json.loads(handcart(*maps, "--json").out)["walls"][0]
    assert figures == {"median_m": None, "p95_m": None, "missing_in_other": None}
    assert "not compared, right.yaml knows nothing at their places" in handcart(*maps).out
