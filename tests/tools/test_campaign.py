"""`handcart campaign`: how each action ended."""

from __future__ import annotations

import json

import pytest


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
