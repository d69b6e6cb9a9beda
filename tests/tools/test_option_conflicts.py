"""Options that would silently override each other, or have no effect, are refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.tools.hardware import ros_bench
from handcart.tools.hardware.ros_bench import RosBenchOptions

from .conftest import Said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "TOUR", "--robot", "cart", "--set", "robot=tiago"), "'robot' is also given as 'tiago'"),
        (("run", "TOUR", "--dry-run", "--set", "a=1", "--set", "a=2"), "'a' is also given as '1'"),
        (("run", "TOUR", "--policy", "rule", "--set", "policy=expected_cost"), "'policy' is also given as"),
        (("run", "TOUR", "--port", "9000"), "--port without --view; needed: both"),
        (("run", "TOUR", "--node-namespace", "a"), "--node-namespace without --node; needed: both"),
        (("resume", "TOUR", "--node-namespace", "a"), "--node-namespace without --node; needed: both"),
        (("campaign", "TOUR", "--robot", "cart", "--set", "robot=tiago"), "'robot' is also given as"),
        (("check", "TOUR", "--policy", "rule", "--set", "policy=expected_cost"), "'policy' is also given"),
        (("check", "cart", "--seconds", "3"), "--seconds without --ros2; needed: both"),
        (("do", "MOVE_TO", "place=dock", "place=shelf"), "'place' is also given as 'dock'"),
        (
            ("do", "MOVE_TO", "place=dock", "--knowledge", "TOUR", "--set", "a=1", "--set", "a=2"),
            "'a' is also given",
        ),
        (("robot", "r/r.yaml", "--from-ros", "--bench", "cart", "--domain", "3"), "--domain with --bench"),
        (("conformance", "--part", "checks", "--task", "return_book"), "--task without --part tasks"),
        (("conformance", "--part", "checks", "--seeds", "3"), "--seeds without --part tasks"),
        (("conformance", "--part", "mutants", "--instants", "3"), "--instants without --part faults"),
    ],
)
def test_options_that_override_each_other_are_refused(
    handcart: Callable[..., Said],
    tour: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tour.parent)
    said = handcart(*(str(tour) if word == "TOUR" else word for word in words))
    assert said.status == 2
    assert message in " ".join(said.err.split())


def test_one_value_given_twice_is_no_conflict(handcart: Callable[..., Said], tour: Path) -> None:
    words = ("--dry-run", "--robot", "librarian", "--set", "robot=librarian")
    assert handcart("run", tour, *words).status == 0


@pytest.mark.parametrize(("robot", "simulated"), [(("cart",), "cart"), ((), "librarian")])
def test_a_bench_of_a_task_simulates_the_named_robot(
    handcart: Callable[..., Said],
    tour: Path,
    monkeypatch: pytest.MonkeyPatch,
    robot: tuple[str, ...],
    simulated: str,
) -> None:
    found: list[str] = []

    def serve(options: RosBenchOptions) -> None:
        spec, inner = ros_bench.simulated_robot(options)
        inner.close()
        found.append(spec.folder.name)

    monkeypatch.setattr(ros_bench, "serve_topics", serve)
    assert handcart("bench", *robot, "--ros2", "--task", tour).status == 0
    assert found == [simulated]
