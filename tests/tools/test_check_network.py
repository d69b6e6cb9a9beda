"""`handcart check` on a task's network."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from networks.analysis.figures import ASSUMPTION

ROOT = Path(__file__).resolve().parents[2]


def test_probabilities_give_figures_with_their_assumption(handcart, tour):
    tour.write_text(tour.read_text().replace("cost_s: 30,", "cost_s: 30, p: 0.9,"))
    said = handcart("check", tour)
    assert said.status == 0
    assert ASSUMPTION in said.out
    assert "P(goal) 0.99900" in said.out
    figures = json.loads(handcart("check", tour, "--json").out)["figures"]
    assert figures["cost_s"] == pytest.approx(33.3)
    assert figures["actions"][0]["one_more_p_goal"] == pytest.approx(0.9999)
    # d/dp of 1 - (1 - p)³
    assert figures["actions"][0]["slope"] == pytest.approx(3 * 0.1**2, rel=1e-3)


def test_a_situation_that_no_run_comes_to_and_one_that_leads_nowhere(handcart, tour):
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


def test_a_goal_that_nothing_leads_to_is_an_error(handcart, tour):
    """N1"""
    tour.write_text(tour.read_text().replace("to: at_shelf", "to: at_home"))
    said = handcart("check", tour)
    assert said.status == 2
    assert f"{tour}:7:" in said.err
    assert "no actions lead from at_home to at_shelf" in said.err


def test_facts_that_a_primitive_cannot_change(handcart, tour):
    tour.write_text(tour.read_text().replace("do: MOVE_TO", "do: MODIFY"))
    said = handcart("check", tour)
    assert "MODIFY moves no Base, but 'base' goes from home to shelf" in said.out


def test_the_papers_table(handcart):
    from pathlib import Path

    said = handcart(
        "check", Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "paper_table.yaml"
    )
    assert said.status == 0
    assert (
        "if each succeeds with 0.9, independently: GIVEUP 0.19000, GOAL 0.78053, row 13 0.02947" in said.out
    )
    assert "RELEASE is required and has no row" in said.out
