"""Reports of `check` and `run --dry-run` on places."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import Finding
from handcart.networks.task.preparing import check
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.navigation.maps.grid_map import from_boxes
from tests.tools.conftest import Said

WALLS = [
    (4.0, 0.0, 0.0, 8.1, 0.1),
    (4.0, 4.0, 0.0, 8.1, 0.1),
    (0.0, 2.0, 0.0, 0.1, 4.1),
    (8.0, 2.0, 0.0, 0.1, 4.1),
    (4.0, 0.75, 0.0, 0.1, 1.5),
    (4.0, 3.05, 0.0, 0.1, 1.9),
    (6.5, 3.0, 0.0, 0.1, 2.0),
    (7.2, 2.0, 0.0, 1.5, 0.1),
]
"""A door of 0.6 m in the middle; a closet in the far corner."""
PLACES = {
    "home": (1.0, 1.0),
    "desk": (2.0, 3.0),
    "near": (1.0, 0.36),
    "behind": (5.5, 2.0),
    "closet": (7.2, 3.0),
}
TASK = """\
format: handcart-task/1
title: Drive
robot: cart
world: map.yaml
knowledge: {map: map.yaml, places: places.yaml, start: home}
start: here
goal: there
situations: {here: , there: }
actions:
"""


@pytest.fixture
def task(tmp_path: Path) -> Callable[..., Path]:
    grid = from_boxes(WALLS, 0.05, (-0.3, -0.3), (8.6, 4.6))
    cv2.imwrite(str(tmp_path / "map.png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    head = "image: map.png\nresolution: 0.05\norigin: [-0.3, -0.3, 0]\n"
    (tmp_path / "map.yaml").write_text(head + "occupied_thresh: 0.65\nfree_thresh: 0.196\n", "utf-8")
    lines = [f"  {name}: {{x_m: {x}, y_m: {y}, heading_deg: 0}}\n" for name, (x, y) in PLACES.items()]
    (tmp_path / "places.yaml").write_text(f"format: handcart-places/1\nplaces:\n{''.join(lines)}", "utf-8")

    def written(*names: str) -> Path:
        actions = [
            f"  - {{do: MOVE_TO, from: here, to: there, cost_s: 1, with: {{place: {n}}}}}\n" for n in names
        ]
        (tmp_path / "task.yaml").write_text(TASK + "".join(actions), "utf-8")
        return tmp_path / "task.yaml"

    return written


def test_check_reports_clearance_and_reachability_of_each_place(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    said = handcart("check", task("desk", "behind", "closet"), "--json")
    found = json.loads(said.out)
    assert (said.status, found["ok"]) == (2, False)
    rooms = {place["name"]: place for place in found["places"]}
    assert {name: room["why_not"] for name, room in rooms.items()} == {
        "home": None,
        "desk": None,
        "near": "too near",
        "behind": "too narrow",
        "closet": "cut off",
    }
    assert [name for name, room in rooms.items() if room["reachable"]] == ["home", "desk"]
    assert rooms["desk"]["component"] == rooms["home"]["component"] != rooms["behind"]["component"]
    assert rooms["desk"] | {"clearance_m": 0.95, "needed_m": 0.38, "fits": True, "line": 4} == rooms["desk"]
    narrow = rooms["behind"]
    assert narrow["narrow_m"] == pytest.approx([4.0, 1.8], abs=0.1)
    assert (narrow["width_m"], narrow["width_needed_m"]) == (pytest.approx(0.6, abs=0.051), 0.72)
    assert [(finding["line"], finding["column"]) for finding in found["findings"]] == [(6, 3), (7, 3)]


def test_computed_places_are_listed_after_those_of_the_file(
    handcart: Callable[..., Said], task: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fitted(model: WorldModel, robot: RobotFile) -> list[Finding]:
        model.places = {**model.places, "table": model.places["desk"]}
        return []

    monkeypatch.setattr(WorldModel, "fit", fitted)
    said = handcart("check", task("desk"))
    listed = [line for line in said.out.splitlines() if line.startswith("  place ")]
    assert listed[-1] == "  place table, computed: x 2.00 m, y 3.00 m, heading 0 deg"
    assert not any("computed" in line for line in listed[:-1])
    found = json.loads(handcart("check", task("desk"), "--json").out)
    assert found["computed_places"] == [{"name": "table", "x_m": 2.0, "y_m": 3.0, "heading_deg": 0.0}]
    assert listed[-1][2:] in handcart("run", "--dry-run", task("desk")).out


def test_a_place_that_nothing_drives_to_is_a_warning_alone(task: Callable[..., Path]) -> None:
    checked = check(task("desk"))
    assert checked.errors == ()
    warnings = [warning.partition("places.yaml:")[2] for warning in checked.warnings]
    unused = "5:3: no action uses the place 'near'; something at (1.00, 0.05) m leaves 0.310 m"
    assert warnings[0].startswith(unused)
    assert [warning[:4] for warning in warnings] == ["5:3:", "6:3:", "7:3:"]


def test_a_place_that_nothing_uses_is_told_and_no_warning(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    """Tasks share a file of places."""
    said = handcart("check", task("home"))
    assert re.search(r"place desk: .* no action uses it", said.out)
    assert "place 'desk'" not in said.out + said.err


def test_errors_say_at_the_line_of_the_place_what_is_too_little(task: Callable[..., Path]) -> None:
    near, behind, closet = map(str, check(task("near", "behind", "closet")).errors)
    assert near.endswith(
        "places.yaml:5:3: the robot can't stand at the place 'near': something at (1.00, 0.05) m leaves "
        "0.310 m to its middle, needed: 0.380 m"
    )
    assert "6:3: no way leads to the place 'behind' from 'home': the way is too narrow: 0." in behind
    assert closet.endswith("'home': it is cut off: no free space leads there; needed: a way on the map")


def test_a_dry_run_tells_the_same_and_refuses_what_a_run_does(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    said = handcart("run", "--dry-run", "--json", task("desk"))
    found = json.loads(said.out)
    assert (said.status, found["outcome"], len(found["places"])) == (0, "Success", 5)
    said = handcart("run", "--dry-run", task("behind"))
    assert said.status == 2
    assert (
        "place behind: 0.95 m to something, needed: 0.38 m; component 2; not reached: the way is" in said.out
    )
    assert "places.yaml:6:3: no way leads to the place 'behind' from 'home'" in said.err
    assert handcart("run", task("behind")).status == 2


def test_place_only_passed_is_reported_without_a_limit() -> None:
    """`place: {model: book.shelf}`: any shelf may be meant."""
    shipped = Path(__file__).resolve().parents[3] / "tasks" / "return_book" / "task.yaml"
    checked = check(shipped)
    assert (checked.errors, checked.warnings) == ((), ())
    assert all(place.used for place in checked.places)
