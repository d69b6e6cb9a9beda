"""`python -m benchmarks` lists each benchmark with what it measures."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.__main__ import listed
from tests.benchmark_help import benchmark_helps

ROOT = Path(__file__).resolve().parents[2]


def test_each_is_listed_with_what_it_measures() -> None:
    found = dict(listed())
    modules = [
        path for path in (ROOT / "benchmarks").rglob("*.py") if path.stem not in ("__init__", "__main__")
    ]
    commands = [path for path in modules if "parse_args(" in path.read_text(encoding="utf-8")]
    assert commands
    for path in commands:
        assert ".".join(path.relative_to(ROOT).with_suffix("").parts) in found
    assert all(about and "python" not in about and "\n" not in about for about in found.values())


@pytest.mark.slow
def test_a_word_chooses() -> None:
    assert all("campaign" in f"{name} {about}".lower() for name, about in listed("Campaign"))
    assert "benchmarks.hostile.crashes" in dict(listed("Kill return_book"))
    assert list(listed("no such thing")) == []


@pytest.mark.slow
def test_each_tells_how_it_is_called() -> None:
    """And begins nothing."""
    names = [name for name, _ in listed()]
    found = benchmark_helps(names)
    assert len(found) == len(names) > 40
    shown = [name for name, help_ in found.items() if help_.text.lower().lstrip().startswith("usage")]
    assert [name for name in names if name not in shown or found[name].status] == []
