"""`handcart check` on a task's network."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.networks.analysis.figures import FORECAST_ASSUMPTION
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_probabilities_give_figures_with_their_assumption(handcart: Callable[..., Said], tour: Path) -> None:
    tour.write_text(tour.read_text().replace("cost_s: 30,", "cost_s: 30, p: 0.9,"))
    said = handcart("check", tour)
    assert said.status == 0
    assert FORECAST_ASSUMPTION in said.out
    assert "P(goal) 0.99900" in said.out
    figures = json.loads(handcart("check", tour, "--json").out)["figures"]
    assert figures["cost_s"] == pytest.approx(33.3)
    assert figures["actions"][0]["one_more_p_goal"] == pytest.approx(0.9999)
    # d/dp of 1 - (1 - p)³
    assert figures["actions"][0]["slope"] == pytest.approx(3 * 0.1**2, rel=1e-3)


def test_a_situation_that_no_run_comes_to_and_one_that_leads_nowhere(
    handcart: Callable[..., Said], tour: Path
) -> None:
    text = tour.read_text().replace(
        "at_shelf: {base: shelf}}", "at_shelf: {base: shelf}, lost: {}, stuck: {}}"
    )
    more = "  - {do: MOVE_TO, from: at_home, to: stuck, cost_s: 90, with: {place: shelf_3}}\n"
    tour.write_text(text + more)
    said = handcart("check", tour)
    assert said.status == 0
    assert "no run comes to 'lost'" in said.out
    assert "from 'stuck' nothing leads to the goal" in said.out
    assert "at_home to stuck" in said.out
    assert f"{tour}:8:" in said.out


@pytest.mark.slow
def test_of_many_lines_of_a_kind_the_first_are_printed(handcart: Callable[..., Said], tour: Path) -> None:
    text = tour.read_text().replace("cost_s: 30,", "cost_s: 30, p: 0.9,")
    action = next(line for line in text.splitlines(keepends=True) if "do: MOVE_TO" in line)
    tour.write_text(text + 39 * action)
    said = handcart("check", tour)
    assert sum("MOVE_TO" in line for line in said.out.splitlines()) < 40
    assert "and 10 more (`--json` has them all)" in said.out
    assert len(json.loads(handcart("check", tour, "--json").out)["figures"]["actions"]) == 40


def test_a_goal_that_nothing_leads_to_is_an_error(handcart: Callable[..., Said], tour: Path) -> None:
    """N1"""
    tour.write_text(tour.read_text().replace("to: at_shelf", "to: at_home"))
    said = handcart("check", tour)
    assert said.status == 2
    assert f"{tour}:7:" in said.err
    assert "no actions lead from at_home to at_shelf" in said.err


def test_facts_that_a_primitive_cannot_change(handcart: Callable[..., Said], tour: Path) -> None:
    tour.write_text(tour.read_text().replace("do: MOVE_TO", "do: MODIFY"))
    said = handcart("check", tour)
    assert "MODIFY moves no Base, but 'base' goes from home to shelf" in said.out


def test_the_papers_table(handcart: Callable[..., Said]) -> None:
    from pathlib import Path

    said = handcart(
        "check", Path(__file__).resolve().parents[3] / "tasks" / "return_book" / "paper_table.yaml"
    )
    assert said.status == 2
    assert "row 11 leads to row 13, which is missing" in said.err
    assert len(said.err.splitlines()) == 6
    assert (
        "if each succeeds with 0.9, independently: GIVEUP 0.19000, GOAL 0.78053, row 13 0.02947" in said.out
    )
    assert "RELEASE is required and has no row" in said.out


TWO = """\
situations: {at_home: {base: home, book: on the tray}, at_shelf: {base: shelf, book: on the tray}}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, attempts: 2, p: 0.9, p_give_up: 0.02,
     with: {place: shelf_3}}
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 50, attempts: 1, p: 0.8, with: {place: shelf_3}}
"""


@pytest.fixture
def two_ways(tour: Path) -> Path:
    tour.write_text(tour.read_text().partition("situations:")[0] + TWO)
    return tour


@pytest.mark.slow
def test_what_more_tries_would_buy(handcart: Callable[..., Said], two_ways: Path) -> None:
    said = handcart("check", two_ways, "--json")
    report = json.loads(said.out)
    figures = report["figures"]
    # The first way weighs 60 s after a Fail: the second comes between its attempts.
    goal = 0.9 + 0.08 * (0.8 + 0.2 * 0.9)
    assert figures["p_goal"] == pytest.approx(goal)
    assert figures["p_give_up"] == pytest.approx(0.02 + 0.08 * 0.2 * 0.02)
    assert figures["p_no_way"] == pytest.approx(1 - goal - figures["p_give_up"])
    assert figures["p_left_undone"] == 0.0
    first, second = figures["actions"]
    assert (first["action"], first["line"], first["p"]) == ("MOVE_TO (at_home to at_shelf)", 10, 0.9)
    assert first["starts"] == pytest.approx(1 + 0.08 * 0.2)
    assert first["one_more_p_goal"] == pytest.approx(goal + 0.08 * 0.2 * 0.08 * 0.9)
    # Its like comes second, at 30 s; a second chance of GiveUp makes that worth less than one more attempt.
    last = 0.8 + 0.2 * (0.9 + 0.08 * 0.9)
    assert first["alternative_p_goal"] == pytest.approx(0.9 + 0.08 * (0.9 + 0.08 * last))
    assert first["slope"] > second["slope"]
    assert report["longest run"] == "at most 3 actions"
    assert len(report["short"]) == 1
    assert "in 'at_home' no way may be left: MOVE_TO with cost_s: 30 from at_home fails" in report["short"][0]
    said = handcart("check", two_ways)
    assert "where a run may end short of the goal" in said.out
    assert f"{two_ways}:10:5: in 'at_home' no way" in said.out
    assert "one more attempt        an alternative" in said.out


def test_probabilities_that_are_more_than_one_together(handcart: Callable[..., Said], two_ways: Path) -> None:
    two_ways.write_text(two_ways.read_text().replace("p_give_up: 0.02", "p_give_up: 0.2"))
    said = handcart("check", two_ways)
    assert said.status == 2
    assert f"{two_ways}:10:" in said.err
    assert "p_give_up is 0.2; allowed: at most 0.1, what p leaves of 1" in said.err


def test_probabilities_that_are_missing_are_named(handcart: Callable[..., Said], two_ways: Path) -> None:
    two_ways.write_text(two_ways.read_text().replace(" p: 0.8,", ""))
    said = handcart("check", two_ways)
    assert said.status == 0
    assert "how runs end: not known: `p` is missing in MOVE_TO (line 12)" in said.out


def test_an_action_that_no_run_does(handcart: Callable[..., Said], two_ways: Path) -> None:
    text = two_ways.read_text().replace(
        "{base: shelf, book: on the tray}", "{base: shelf, book: on the tray}, b: {}"
    )
    more = "  - {do: MODIFY, from: at_shelf, to: at_home, cost_s: 1, with: {place: shelf_3}}\n"
    more += "  - {do: MOVE_TO, from: at_home, to: b, cost_s: 1, with: {place: shelf_3}}\n"
    more += "  - {do: MOVE_TO, from: b, to: at_home, cost_s: 1, with: {place: shelf_3}}\n"
    two_ways.write_text(text + more)
    said = handcart("check", two_ways)
    assert said.status == 0
    assert f"{two_ways}:14:5: no run ever does MOVE_TO from 'at_home', whatever fails" in said.out


DEAD_END = """\
situations:
  at_home: {base: home}
  lost: {base: home}
  at_shelf: {base: shelf}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, on_fail: lost, cost_s: 30, with: {place: shelf_3}}
"""


def test_a_dead_end_that_a_fail_leads_to_is_told_with_its_path(
    handcart: Callable[..., Said], tour: Path
) -> None:
    tour.write_text(tour.read_text().partition("situations:")[0] + DEAD_END)
    said = handcart("check", tour)
    assert said.status == 0
    lost = (
        "from 'lost' nothing leads to the goal: a run that comes there (at_home to lost) ends with status 3"
    )
    assert f"{tour}:10:9: {lost}" in said.out
    assert f"{tour}:13:5: in 'lost' no way may be left: MOVE_TO from at_home fails" in said.out


def test_a_primitive_that_changes_more_than_elsewhere(handcart: Callable[..., Said], tour: Path) -> None:
    """RELEASE has no row in the paper's table: there the last MOVE_TO also puts the book in its place."""
    head = tour.read_text().partition("situations:")[0].replace("goal: at_shelf", "goal: home_again")
    tour.write_text(
        head
        + """\
situations:
  at_home: {base: home, book: in hand}
  at_shelf: {base: shelf, book: in hand}
  home_again: {base: home, book: in its place}
actions:
  - {do: MOVE_TO, from: at_home, to: at_shelf, cost_s: 30, with: {place: shelf_3}}
  - {do: MOVE_TO, from: at_shelf, to: home_again, cost_s: 30, with: {place: home}}
"""
    )
    said = handcart("check", tour)
    assert said.status == 0
    assert f"{tour}:14:" in said.out
    assert "MOVE_TO also changes 'book' here, which it doesn't in line 13" in said.out
