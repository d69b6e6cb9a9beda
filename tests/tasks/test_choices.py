"""The shipped tasks have further ways, which change nothing while nothing fails."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from benchmarks.deciding.choices import TASK_NAMES, mean_difference, share_difference, verdict
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import Plan, Planner
from handcart.networks.task.task_file import Task, load_task

TASKS_FOLDER = Path(__file__).parents[2] / "tasks"


def load(name: str, file: str) -> Task:
    return load_task(TASKS_FOLDER / name / file)


def steps(task: Task) -> list[tuple[str, str, str, object, float]]:
    plan = Planner(task.network).plan(task.network.start)
    assert isinstance(plan, Plan)
    return [
        (a.do, a.source, a.target, a.binding.given() if a.binding else {}, a.cost_s) for a in plan.actions
    ]


def choices(task: Task) -> int:
    """Number of situations with several actions out, skips apart."""
    out = Counter(a.source for a in task.network.actions if a.binding is not None)
    return sum(count > 1 for count in out.values())


@pytest.mark.parametrize("name", TASK_NAMES)
def test_first_plan_is_that_of_the_paper(name: str) -> None:
    chosen, paper = load(name, "task.yaml"), load(name, "paper.yaml")
    assert steps(chosen) == steps(paper)
    assert choices(chosen) >= 3 > choices(paper)
    assert chosen.network.restoring.attempts == 3 and paper.network.restoring.attempts == 1


@pytest.mark.parametrize(
    ("name", "step"), [("track_seam", -1), ("stack_blocks", -1), ("deploy_zigzag", -1), ("return_book", 1)]
)
def test_another_way_is_left_where_the_paper_has_none(name: str, step: int) -> None:
    assert _after_all_fails(load(name, "paper.yaml"), step) is None
    assert _after_all_fails(load(name, "task.yaml"), step) is not None


@pytest.mark.parametrize("name", ["deploy_zigzag", "deploy_straight", "deploy_field"])
def test_a_robot_unsure_of_its_place_stands_before_it_drives(name: str) -> None:
    """Standing also gives the attempts of driving back: a receiver's errors average out."""
    network = load(name, "task.yaml").network
    drive = next(a for a in network.actions if a.do == "MOVE_TO")
    planner = Planner(network)
    planner.failed(drive, "not determined")
    plan = planner.plan(drive.after_fail("undetermined"))
    assert isinstance(plan, Plan)
    assert [a.do for a in plan.actions[:2]] == ["STAND", "MOVE_TO"]
    planner.succeeded(plan.actions[0])
    assert planner.fails(drive) == 0


def _after_all_fails(task: Task, step: int) -> Action | None:
    """Return the next action where a step of the plan has failed as often as it may; None for a skip."""
    planner = Planner(task.network)
    plan = planner.plan(task.network.start)
    assert isinstance(plan, Plan)
    last = plan.actions[step]
    for _ in range(last.attempts):
        planner.failed(last, "nobody knows")
    after = planner.plan(last.on_fail or last.source)
    return after.actions[0] if isinstance(after, Plan) and after.actions[0].binding else None


def test_intervals_of_pairs_are_those_of_their_authors() -> None:
    """Agresti and Min (2005), with 0.5 more in each of four cells; Student with two pairs."""
    found = share_difference([False] * 8 + [True] * 2, [True] * 5 + [False] * 3 + [True, False])
    assert found.mean == pytest.approx(0.4)
    assert (found.low + found.high) / 2 == pytest.approx(4 / 12)
    assert found.high - found.low == pytest.approx(2 * 1.959964 * (7 - 16 / 12) ** 0.5 / 12)
    price = mean_difference([10.0, 20.0], [12.0, 26.0])
    assert price.mean == 4.0 and price.high - 4.0 == pytest.approx(12.7062 * 2.0, abs=1e-3)


def test_better_needs_an_interval_without_zero() -> None:
    none, many = share_difference([True, False] * 9, [True, False] * 9), [False] * 20
    gained = share_difference(many, [True] * 15 + [False] * 5)
    dearer = mean_difference([1.0, 2.0, 3.0], [11.0, 12.1, 13.0])
    same = mean_difference([1.0, 2.0, 3.0], [2.0, 1.0, 3.0])
    assert verdict(none, same) == "not different for sure"
    assert (verdict(gained, same), verdict(none, dearer)) == ("better", "worse")
    assert verdict(gained, dearer) == "better and worse"
