"""`handcart check` and `--dry-run` on networks with choices, and on those that only a Fail leads through."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

FALSE_STEP = """\
situations: {a: {}, b: {}, stuck: {}, z: {}}
actions:
  - {do: MODIFY, from: a, to: z, on_fail: stuck, cost_s: 10, p: 0.5, with: {place: shelf_3}}
  - {do: MODIFY, from: a, to: b, cost_s: 10, p: 0.99, with: {place: shelf_3}}
  - {do: MODIFY, from: b, to: z, cost_s: 10, p: 0.99, with: {place: shelf_3}}
"""
ONLY_A_FAIL = """\
situations: {a: {}, b: {}, dead: {}, z: {}}
actions:
  - {do: MODIFY, from: a, to: z, cost_s: 90, attempts: 1, p: 0.5, with: {place: shelf_3}}
  - {do: MODIFY, from: a, to: dead, on_fail: b, cost_s: 5, attempts: 1, p: 0.1, with: {place: shelf_3}}
  - {do: MODIFY, from: b, to: z, cost_s: 5, p: 0.99, with: {place: shelf_3}}
"""


@pytest.fixture
def task(tour: Path) -> Callable[..., Path]:
    """Writes the network of a task."""
    head = tour.read_text().partition("\nstart:")[0] + "\n"

    def write(network: str, start: str = "a", goal: str = "z") -> Path:
        tour.write_text(f"{head}start: {start}\ngoal: {goal}\n{network}")
        return tour

    return write


def test_a_route_through_a_fail_alone_is_taken_last(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    figures = json.loads(handcart("check", task(ONLY_A_FAIL), "--json").out)["figures"]
    # The route of Successes first; after its Fail, the action whose Fail leads on.
    assert figures["p_goal"] == pytest.approx(0.5 + 0.5 * 0.9 * (1 - 0.01**3), abs=1e-12)


@pytest.mark.slow
def test_a_goal_that_only_a_fail_leads_to_can_be_reached(
    handcart: Callable[..., Said], task: Callable[..., Path], tmp_path: Path
) -> None:
    path = task(ONLY_A_FAIL.replace("from: a, to: z", "from: b, to: z"))
    said = json.loads(handcart("check", path, "--json").out)
    assert said["ok"]
    assert said["figures"]["p_goal"] == pytest.approx(0.9 * (1 - 0.5 * 0.01**3), abs=1e-12)
    script = tmp_path / "script.yaml"
    script.write_text("format: handcart-script/1\noutcomes: [Fail]\n")
    done = json.loads(handcart("run", path, "--dry-run", "--script", script, "--json").out)
    assert (done["outcome"], done["actions"]) == ("Success", 2)
    script.write_text("format: handcart-script/1\noutcomes: [Success]\n")
    done = json.loads(handcart("run", path, "--dry-run", "--script", script, "--json").out)
    assert (done["outcome"], done["situation"]) == ("Fail", "dead")


@pytest.mark.slow
def test_fails_of_probability_zero_are_not_followed(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    """A ring in which each action could fail 20 times would have 21 to the power of 31 states."""
    count = 30
    rows = [f"{{from: s{i}, to: s{i + 1}, cost_s: 2, p: 1}}" for i in range(count)]
    rows += [f"{{from: s{i + 1}, to: s{i}, cost_s: 1, p: 1}}" for i in range(count)]
    rows += [f"{{from: s{count}, to: z, cost_s: 1, p: 0.5}}"]
    common = "- {do: MODIFY, attempts: 20, with: {place: shelf_3}, "
    actions = "\n".join(f"  {common}{row[1:]}" for row in rows)
    names = ", ".join(f"s{i}: {{}}" for i in range(count + 1))
    path = task(f"situations: {{{names}, z: {{}}}}\nactions:\n{actions}\n", start="s0")
    figures = json.loads(handcart("check", path, "--json").out)["figures"]
    assert figures["p_goal"] == pytest.approx(1 - 0.5**20, abs=1e-12)
    assert figures["p_unknown"] == 0.0


@pytest.mark.slow
def test_a_network_that_is_too_large_has_an_interval(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    rows = []
    for i in range(40):
        rows.append(f"from: s{i}, to: s{(i * 7 + 1) % 40}, cost_s: {3 + i % 5}, p: 0.8")
        rows.append(f"from: s{i}, to: s{i + 1 if i < 39 else 5}, cost_s: {4 + i % 7}, p: 0.7")
    actions = "\n".join(f"  - {{do: MODIFY, {row}, with: {{place: shelf_3}}}}" for row in rows)
    names = ", ".join(f"s{i}: {{}}" for i in range(41))
    network = f"situations: {{{names}}}\nactions:\n{actions}\n".replace("to: s5,", "to: s40,", 1)
    said = handcart("check", task(network, "s0", "s40"), "--json")
    report = json.loads(said.out)
    figures = report["figures"]
    assert 0.0 < figures["p_unknown"] < 1.0
    assert figures["p_goal"] + figures["p_unknown"] <= 1.0 + 1e-9
    assert figures["cost_s"] < figures["cost_high_s"]
    assert "not known" not in said.out
    assert "between " in report["longest run"]


def test_a_goal_that_is_the_start_is_an_error(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    said = handcart("check", task(FALSE_STEP, goal="a"))
    assert said.status == 2
    assert ":7:7: the start is the goal, 'a': a run would do nothing" in said.err


@pytest.mark.parametrize("goal", ["[a, b]", "{a: b}", "5"])
def test_a_goal_that_is_no_name_shows_nothing_internal(
    handcart: Callable[..., Said], task: Callable[..., Path], goal: str
) -> None:
    said = handcart("check", task(FALSE_STEP, goal=goal))
    assert said.status == 2
    assert "Node(" not in said.err
    assert len(said.err.splitlines()) == 1


@pytest.mark.slow
def test_a_file_of_three_thousand_actions_is_read(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    rows = [
        f"  - {{do: MODIFY, from: s{i}, to: s{i + 1}, cost_s: 5, with: {{place: shelf_3}}}}\n"
        for i in range(3000)
    ]
    names = "".join(f"  s{i}: {{}}\n" for i in range(3001))
    path = task(f"situations:\n{names}\nactions:\n{''.join(rows)}", "s0", "s3000")
    said = json.loads(handcart("run", path, "--dry-run", "--json").out)
    assert (said["outcome"], said["actions"]) == ("Success", 3000)
