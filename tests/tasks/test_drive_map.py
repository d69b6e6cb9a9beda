"""The task drive_map on its own map and on real ones, through `handcart run`'s own functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.files.errors import FileError
from handcart.networks.events.events import Ended
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.run_files.run_folder import JOURNAL_FILE
from handcart.networks.runs.run import execute, prepare
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.outcomes.outcome import Success

ROOT = Path(__file__).resolve().parents[2]
TASK = ROOT / "tasks" / "drive_map" / "task.yaml"
MAPS = ROOT / "../shared/maps"
REAL = {
    "turtlebot3/map.yaml": """
  home: {x_m: -2.0, y_m: 0.0, heading_deg: 0.0}
  south: {x_m: 0.0, y_m: -1.8, heading_deg: 0.0}
  east: {x_m: 1.9, y_m: 0.45, heading_deg: 90.0}
  north: {x_m: 0.0, y_m: 1.8, heading_deg: 180.0}
  between_pillars: {x_m: 0.55, y_m: 0.55, heading_deg: -90.0}
""",
    "depot/depot.yaml": """
  home: {x_m: 3.0, y_m: 3.0, heading_deg: 0.0}
  aisle: {x_m: 16.9, y_m: 4.4, heading_deg: 0.0}
  east_end: {x_m: 28.5, y_m: 5.0, heading_deg: 90.0}
  posts: {x_m: 22.7, y_m: 9.0, heading_deg: 180.0}
  north_west: {x_m: 3.0, y_m: 12.5, heading_deg: -90.0}
""",
}


@dataclass
class Arrivals(RunObserver):
    """True distance in [m] of the robot from its place after each MOVE_TO that succeeded."""

    scene: Any
    places: Any
    errors: dict[str, float] = field(default_factory=dict)

    def event(self, event: object) -> None:
        if isinstance(event, Ended) and isinstance(event.outcome, Success):
            primitive: Any = event.primitive
            name = primitive.place
            self.errors[name] = self.scene.base.distance(self.places[name].pose)


@pytest.fixture
def places(tmp_path: Path) -> Callable[[str], str]:
    def written(text: str) -> str:
        path = tmp_path / "places.yaml"
        path.write_text("format: handcart-places/1\nplaces:" + text, encoding="utf-8")
        return str(path)

    return written


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_the_places_of_a_real_map_are_reached(
    tmp_path: Path, places: Callable[[str], str], name: str
) -> None:
    chart = MAPS / name
    if not chart.is_file():
        pytest.skip(f"the map {name} is not there: it lies outside the repository")
    with prepare(TASK, settings={"map": str(chart), "places": places(REAL[name])}) as prepared:
        arrivals = Arrivals(prepared.backend.scene, prepared.model.places)  # type: ignore[attr-defined]
        end = execute(prepared, tmp_path / "run", RunOptions(observers=(arrivals,))).end
        assert prepared.backend.scene.contacts == []  # type: ignore[attr-defined]
    assert end.exit_status == 0
    assert arrivals.errors.keys() == prepared.model.places.keys()
    assert max(arrivals.errors.values()) < 0.05


@pytest.mark.slow
def test_as_it_stands_it_drives_through_an_office_and_draws_it(tmp_path: Path) -> None:
    summary, status = run_task(TASK, tmp_path, RunOptions(seed=1, draw=True))
    assert status == 0
    assert (summary["actions"], summary["fails"], summary["metrics"]["untrue"]) == (6, 0, [])
    drawn = (tmp_path / "drive_map-1" / "overview.svg").read_text(encoding="utf-8")
    assert all(word in drawn for word in ("Voronoi graph", "planned", "driven", "scan on arrival", "kitchen"))


def test_a_place_without_room_is_refused_at_its_line(places: Callable[[str], str]) -> None:
    places_file = places("""
  home: {x_m: 1.0, y_m: 5.2, heading_deg: 0.0}
  nook: {x_m: 15.85, y_m: 0.8, heading_deg: 0.0}
  desk: {x_m: 2.0, y_m: 2.4, heading_deg: -90.0}
""")
    with pytest.raises(FileError) as refused:
        prepare(TASK, settings={"places": places_file, "tour": "[nook, desk]"})
    assert "places.yaml:4:3: the robot can't stand at the place 'nook': something at (" in str(refused.value)
    prepare(TASK, settings={"places": places_file, "tour": "[desk]"}).backend.close()  # nothing drives there


@pytest.mark.slow
def test_occupied_place_is_skipped_and_the_others_are_visited(
    tmp_path: Path, places: Callable[[str], str]
) -> None:
    places_file = places("""
  home: {x_m: 1.0, y_m: 5.2, heading_deg: 0.0}
  taken: {x_m: 3.0, y_m: 5.2, heading_deg: 0.0}
  desk: {x_m: 2.0, y_m: 2.4, heading_deg: -90.0}
""")
    world = tmp_path / "world.yaml"
    for name in ("map.yaml", "map.png"):
        (tmp_path / name).write_bytes((TASK.parent / name).read_bytes())
    world.write_text(
        "format: handcart-world/1\nmap: map.yaml\nstart: {x_m: 1.0, y_m: 5.2}\n"
        "surprises: [{name: pallet, x_m: 3.0, y_m: 5.2, size_m: [0.6, 0.6, 0.5]}]\n",
        encoding="utf-8",
    )
    settings = {"world": str(world), "places": places_file, "tour": "[taken, desk]", "wait_s": "1.0"}
    summary, status = run_task(TASK, tmp_path / "runs", RunOptions(settings=settings, seed=1))
    assert status == 3
    assert summary["skipped"] == ["place[1] (taken)"]
    assert summary["metrics"]["untrue"] == []


@pytest.mark.slow
def test_what_the_map_does_not_show_is_driven_around(tmp_path: Path) -> None:
    for name in ("map.yaml", "map.png"):
        (tmp_path / name).write_bytes((TASK.parent / name).read_bytes())
    world = tmp_path / "world.yaml"
    world.write_text(
        "format: handcart-world/1\nmap: map.yaml\nstart: {x_m: 1.0, y_m: 5.2}\n"
        "surprises: [{name: pallet, x_m: 5.0, y_m: 4.7, size_m: [0.6, 0.6, 0.5]}]\n",
        encoding="utf-8",
    )
    settings = {"world": str(world), "tour": "[kitchen]"}
    summary, status = run_task(TASK, tmp_path / "runs", RunOptions(settings=settings, seed=1))
    assert status == 0
    assert summary["fails"] == 0
    assert summary["metrics"]["untrue"] == []


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (
            "{x_m: 7.7, y_m: 1.7, heading_deg: 0.0}",
            "'here' is in an obstacle of map.yaml; allowed: the free",
        ),
        ("{x_m: 16.3, y_m: 1.0, heading_deg: 0.0}", "'here' is in unknown space of map.yaml"),
        ("{x_m: -0.6, y_m: 1.0, heading_deg: 0.0}", "'here' is outside map.yaml"),
    ],
)
def test_a_place_outside_the_free_space_is_told_with_its_line(
    places: Callable[[str], str], place: str, words: str
) -> None:
    places_file = places(f"\n  home: {{x_m: 1.0, y_m: 5.2, heading_deg: 0.0}}\n  here: {place}\n")
    with pytest.raises(FileError) as refused:
        prepare(TASK, settings={"places": places_file})
    assert f"places.yaml:4:3: place {words}" in str(refused.value)


def test_names_in_the_tour_are_checked() -> None:
    with pytest.raises(FileError, match=r"unknown place 'kichen'; did you mean 'kitchen'\?"):
        prepare(TASK, settings={"tour": "[desk, kichen]"})


@pytest.mark.slow
def test_patrol_charges_its_battery_and_goes_on(tmp_path: Path) -> None:
    summary, status = run_task(TASK.parent / "patrol.yaml", tmp_path, RunOptions(seed=1))
    assert (status, summary["actions"], summary["metrics"]["untrue"]) == (0, 6, [])
    aims = [r for r in read_journal(tmp_path / "patrol-1" / JOURNAL_FILE).records if r["kind"] == "AIM"]
    assert [(aim["what"], aim["situation"]) for aim in aims] == [
        ("interrupt", "in the meeting room (goal 3)"),
        ("round", "docked (goal 3)"),
    ]
    assert summary["sim_time_s"] > 140.0
