"""One wrong entry is one finding: errors that only follow from it are not reported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

DRIVE_MAP = Path(__file__).resolve().parents[3] / "tasks" / "drive_map"
TWICE = """\
waypoints:
  - {name: home, pose: [1.0, 5.2, 0.0], orientation: [1, 0, 0, 0]}
  - {name: home, pose: [8.6, 8.3, 0.0], orientation: [1, 0, 0, 0]}
"""


@pytest.fixture
def findings(handcart: Callable[..., Any], tmp_path: Path) -> Callable[..., list[str]]:
    """Checks drive_map with a file of places, and gives the lines on stderr."""

    def check(places: str, *words: str) -> list[str]:
        (tmp_path / "places.yaml").write_text(places, encoding="utf-8")
        said = handcart("check", "drive_map", "--set", f"places={tmp_path / 'places.yaml'}", *words)
        assert said.status == 2
        return [line.replace(f"{tmp_path}/", "") for line in said.err.splitlines()]

    return check


def test_broken_places_are_the_only_finding(findings: Callable[..., list[str]]) -> None:
    assert findings(TWICE) == ["places.yaml:3:5: the goal 'home' is there twice; allowed: each name once"]


def test_place_of_another_type_is_one_finding(findings: Callable[..., list[str]]) -> None:
    places = (DRIVE_MAP / "places.yaml").read_text(encoding="utf-8")
    (line,) = findings(places, "--set", "tour=[1]")
    assert line.startswith("--set tour=[1]: place is 1; allowed: text in quotes")


def test_missing_places_are_the_only_finding(handcart: Callable[..., Any], tmp_path: Path) -> None:
    said = handcart("check", "drive_map", "--set", f"places={tmp_path / 'gone.yaml'}")
    assert said.status == 2
    assert len(said.err.splitlines()) == 1, said.err
