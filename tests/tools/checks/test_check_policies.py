"""`handcart check`, `run` and `--dry-run` with policies."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.checks.test_check_choices import FALSE_STEP
from tests.tools.conftest import Said

LONG = """\
situations: {a: {}, z: {}}
actions:
  - {do: MODIFY, from: a, to: z, cost_s: 3000, p: 0.9, with: {place: shelf_3}}
"""


@pytest.fixture
def task(tour: Path) -> Callable[..., Path]:
    """Writes the network of a task."""
    head = tour.read_text().partition("\nstart:")[0] + "\n"

    def write(network: str, keys: str = "") -> Path:
        tour.write_text(f"{head}{keys}start: a\ngoal: z\n{network}")
        return tour

    return write


def test_rule_and_best_policy_are_printed_side_by_side(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    said = handcart("check", task(FALSE_STEP))
    rows = {line.split()[0]: line.split()[1:] for line in said.out.splitlines() if line.startswith("    ")}
    assert rows["rule"][:4] == ["0.50000", "10.0", "s", "10.0"]
    assert rows["expected_cost"][0] == "1.00000"
    assert "a: rule MODIFY (a to z), 10 s, expected_cost MODIFY (a to b), 10 s" in said.out
    policies = json.loads(handcart("check", task(FALSE_STEP), "--json").out)["policies"]
    assert policies["best"]["price_s"] == pytest.approx(2 * 10 / 0.99, abs=2e-3)
    assert policies["rule"]["price_s"] == pytest.approx(310.0)
    assert policies["best"]["time_95_s"] == 20.0


@pytest.mark.slow
def test_check_says_what_beliefs_begin_with(handcart: Callable[..., Said], task: Callable[..., Path]) -> None:
    keys = "policy: expected_cost\nbelief: {{attempts: {}}}\n"
    said = handcart("check", task(FALSE_STEP, keys.format(1000)))
    assert "beliefs (p counts for 1000 attempts): at the start expected_cost is better in 100.0%" in said.out
    assert "the run begins by expected_cost" in said.out
    assert (
        json.loads(handcart("check", task(FALSE_STEP, keys.format(1)), "--json").out)["belief"]["attempts"]
        == 1
    )
    assert "beliefs (" not in handcart("check", task(FALSE_STEP)).out


def test_check_says_plainly_that_a_person_costs_less(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    said = handcart("check", task(LONG))
    assert "expected_cost calls a person at the start" in said.out
    # 3000 s for each of 1.11 attempts
    assert "with person_s above 3333, or policy: goal_probability, it is tried" in said.out
    assert "calls a person" not in handcart("check", task(LONG, "person_s: 3400\n")).out


@pytest.mark.parametrize(
    ("options", "first"),
    [((), "MODIFY (a to z)"), (("--policy", "expected_cost"), "MODIFY (a to b)")],
)
def test_a_dry_run_follows_the_policy_given(
    handcart: Callable[..., Said], task: Callable[..., Path], options: tuple[str, ...], first: str
) -> None:
    said = handcart("run", task(FALSE_STEP), "--dry-run", *options)
    assert said.status == 0
    assert said.out.startswith(f"1. {first}: Success")


@pytest.mark.slow
def test_a_run_and_its_explanation_follow_the_policy(
    handcart: Callable[..., Said], task: Callable[..., Path], tmp_path: Path
) -> None:
    runs = tmp_path / "runs"
    said = handcart("run", task(FALSE_STEP, "policy: goal_probability\n"), "--runs", runs, "--json")
    found = json.loads(said.out.splitlines()[-1])
    assert (said.status, found["actions"]) == (0, 2)
    assert handcart("explain", found["run_dir"]).status == 0


@pytest.mark.slow
def test_a_run_that_calls_a_person_at_once_ends_with_status_4(
    handcart: Callable[..., Said], task: Callable[..., Path], tmp_path: Path
) -> None:
    said = handcart("run", task(LONG, "policy: expected_cost\n"), "--runs", tmp_path / "runs", "--json")
    found = json.loads(said.out.splitlines()[-1])
    assert (said.status, found["outcome"], found["actions"]) == (4, "GiveUp", 0)
    assert "costs more than a person (600 s)" in found["reason"]


def test_a_policy_without_probabilities_is_refused(
    handcart: Callable[..., Said], task: Callable[..., Path]
) -> None:
    bare = FALSE_STEP.replace(", p: 0.5", "")
    said = handcart("run", task(bare), "--policy", "expected_cost")
    assert said.status == 2
    assert "MODIFY has no p, which policy 'expected_cost' needs" in said.err
    assert "Traceback" not in said.err
