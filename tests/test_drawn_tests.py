"""Slow tests that are drawn by a seed: `pytest -m slow --drawn PERCENT --draw-seed SEED`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pytest


@dataclass(frozen=True)
class _Item:
    """A collected test, of which the odd ones are slow."""

    number: int

    def get_closest_marker(self, name: str) -> bool | None:
        return True if name == "slow" and self.number % 2 else None

    @property
    def nodeid(self) -> str:
        return f"tests/test_file.py::test_{self.number}"


def _drawn(request: pytest.FixtureRequest, seed: str, percent: int | None) -> set[int]:
    """Return the numbers of 200 tests that remain selected."""
    own = Path(__file__).with_name("conftest.py")
    plugins = request.config.pluginmanager.get_plugins()
    conftest = next(item for item in plugins if getattr(item, "__file__", None) == str(own))
    options = {"--drawn": percent, "--draw-seed": seed}
    hook = SimpleNamespace(pytest_deselected=lambda items: None)
    items = [_Item(number) for number in range(200)]
    conftest.pytest_collection_modifyitems(SimpleNamespace(getoption=options.get, hook=hook), items)
    return {item.number for item in items}


def test_draws_differ_by_seed_and_together_are_all_slow_tests(request: pytest.FixtureRequest) -> None:
    quick = set(range(0, 200, 2))
    draws = [_drawn(request, seed, 40) for seed in "abcdefghijklmnopqrst"]
    assert all(quick < draw and 20 <= len(draw - quick) <= 60 for draw in draws)
    assert draws[0] != draws[1] and draws[0] == _drawn(request, "a", 40)
    assert set().union(*draws) == _drawn(request, "a", None) == set(range(200))
