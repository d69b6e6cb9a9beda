"""`handcart campaign`: how each action ended."""

from __future__ import annotations

import json

import pytest

ROUNDS = """\
format: handcart-task/1
title: There and back, twice
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: here
goal: done
situations: {here: {base: home}, there: {base: shelf}, done: {base: home}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: {each: shelf}}}
  - {do: MOVE_TO, from: there, to: done, cost_s: 30, with: {place: home}}
repeat: {over: [shelf_1, shelf_5], as: shelf, start: here, goal: done}
"""


@pytest.mark.parametrize("as_json", [False, True])
def test_shares_of_each_action(handcart, tour, tmp_path, as_json):
    words = ("campaign", tour, "--trials", "2", "--jobs", "1", "--runs", tmp_path / "runs")
    said = handcart(*words, *(["--json"] if as_json else []))
    assert said.status == 0
    if as_json:
        (share,) = json.loads(said.out)["actions"]
        assert share["action"] == "MOVE_TO (at_home to at_shelf)"
        assert (share["attempts"], share["p"], share["p_give_up"]) == (2, 1.0, 0.0)
        assert share["p_wilson"] == pytest.approx([0.3424, 1.0], abs=1e-4)
    else:
        line = next(each for each in said.out.splitlines() if each.startswith("MOVE_TO"))
        assert line.split()[-6:] == ["2", "1.000", "0.342", "to", "1.000", "0.000"]


def test_a_repeated_action_is_one_row_named_as_in_the_file(handcart, tour, tmp_path):
    """Of the last element it leads out of the repeat, of the others back to its start."""
    tour.write_text(ROUNDS, encoding="utf-8")
    said = handcart("campaign", tour, "--trials", "1", "--jobs", "1", "--runs", tmp_path / "runs", "--json")
    assert said.status == 0
    shares = [(each["action"], each["attempts"]) for each in json.loads(said.out)["actions"]]
    assert shares == [("MOVE_TO (here to there)", 2), ("MOVE_TO (there to done)", 2)]
