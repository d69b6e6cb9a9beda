"""`route_from`: costs from the model, the driving time along the planned route."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import Plan, Planner
from handcart.networks.task.task_file import Task, load_task

PLACES = """\
format: handcart-places/1
places:
  dock: {x_m: 1.0, y_m: 2.0, heading_deg: 0}
  desk: {x_m: 4.0, y_m: 6.0, heading_deg: 0}
  shelf: {x_m: 1.0, y_m: 3.0, heading_deg: 0}
"""
TASK = """\
format: handcart-task/1
title: t
robot: cart
knowledge: {map: none, places: places.yaml, start: dock}
facts: {base: [dock, desk, shelf]}
known: {desk: [unseen, seen], shelf: [unseen, seen]}
goal: {desk: seen, shelf: seen}
actions:
  - {do: MOVE_TO, then: {base: desk, desk: seen}, cost_s: 2, route_from: base, with: {place: desk}}
  - {do: MOVE_TO, then: {base: shelf, shelf: seen}, cost_s: 2, route_from: base, with: {place: shelf}}
"""
SPEED = load_robot("cart", False).drive.top_speed_m_s


def loaded(folder: Path, text: str = TASK) -> Task:
    (folder / "lib").mkdir(exist_ok=True)
    (folder / "lib" / "places.yaml").write_text(PLACES)
    (folder / "lib" / "task.yaml").write_text(text)
    return load_task(folder / "lib" / "task.yaml")


def cost(task: Task, begin: str, goal: str) -> float:
    """Return the cost of the first action from one place to another."""

    def is_it(action: Action) -> bool:
        facts = task.network.situations[action.source].facts
        fixed = action.binding.fixed if action.binding else {}
        return facts.get("base") == begin and fixed.get("place") == goal

    return next(action.cost_s for action in task.network.actions if is_it(action))


def test_cost_is_the_time_of_the_route_from_where_the_base_is(tmp_path: Path) -> None:
    task = loaded(tmp_path)
    assert cost(task, "dock", "desk") == pytest.approx(2.0 + 5.0 / SPEED, abs=0.01)
    assert cost(task, "dock", "shelf") == pytest.approx(2.0 + 1.0 / SPEED, abs=0.01)
    assert cost(task, "shelf", "desk") == pytest.approx(2.0 + 18.0**0.5 / SPEED, abs=0.01)
    plan = Planner(task.network).plan(task.network.start)
    assert isinstance(plan, Plan)
    assert plan.actions[0].target.startswith("shelf")  # near by first: 1 m and 4.2 m instead of 10 m


def test_written_networks_name_places_in_a_fact_of_situations(tmp_path: Path) -> None:
    head = TASK.partition("facts:")[0]
    network = (
        "start: here\ngoal: done\n"
        "situations: {here: {base: dock}, there: {base: shelf}, done: {base: desk}}\n"
        "actions:\n"
        "  - {do: MOVE_TO, from: here, to: there, cost_s: 1, route_from: base, with: {place: shelf}}\n"
        "  - {do: MOVE_TO, from: there, to: here, cost_s: 1, route_from: base, with: {place: dock}}\n"
        "  - {do: MOVE_TO, from: there, to: done, cost_s: 1, route_from: base, with: {place: desk}}\n"
    )
    task = loaded(tmp_path, head + network)
    assert cost(task, "dock", "shelf") == pytest.approx(1.0 + 1.0 / SPEED, abs=0.01)
    assert cost(task, "shelf", "dock") == cost(task, "dock", "shelf")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("route_from: bse", "has no fact 'bse'; did you mean 'base'"),
        ("route_from: desk", "has no fact 'desk'"),
    ],
)
def test_what_is_no_place_of_the_base_is_named_at_its_line(tmp_path: Path, wrong: str, words: str) -> None:
    with pytest.raises(FileError) as error:
        loaded(
            tmp_path,
            TASK.replace("route_from: base, with: {place: shelf}", f"{wrong}, with: {{place: shelf}}"),
        )
    assert ":10:" in str(error.value)
    assert words in str(error.value)
    assert len(str(error.value).splitlines()) == 1


def test_values_that_are_no_places_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="unknown place 'garage'"):
        loaded(tmp_path, TASK.replace("base: [dock, desk, shelf]", "base: [garage, desk, shelf]"))


@pytest.mark.slow
def test_route_on_a_map_goes_around_walls(tmp_path: Path) -> None:
    """A room whose door is elsewhere takes longer than the straight line."""
    folder = Path(__file__).parents[3] / "tasks" / "drive_map"
    head = TASK.replace(
        "map: none, places: places.yaml, start: dock", "map: map.yaml, places: places.yaml, start: home"
    )
    text = head.replace("[dock, desk, shelf]", "[home, desk, store]").replace("shelf", "store")
    for name in ("map.yaml", "map.png", "places.yaml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "task.yaml").write_text(text)
    task = load_task(tmp_path / "task.yaml")
    places = task.knowledge.all_places()
    for goal in ("desk", "store"):
        straight = places["home"].pose.distance(places[goal].pose) / SPEED
        assert 2.0 + straight - 0.01 <= cost(task, "home", goal) < 2.0 + 4.0 * straight
    assert (
        cost(task, "home", "store") > 2.0 + 1.1 * places["home"].pose.distance(places["store"].pose) / SPEED
    )
