"""`python -m benchmarks` lists each benchmark with what it measures."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from benchmarks.__main__ import listed

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


def test_a_word_chooses() -> None:
    assert all("campaign" in f"{name} {about}".lower() for name, about in listed("Campaign"))
    assert "benchmarks.hostile.crashes" in dict(listed("Kill return_book"))
    assert list(listed("no such thing")) == []


@pytest.mark.slow
def test_each_tells_how_it_is_called() -> None:
    """And begins nothing."""

    def asked(name: str) -> tuple[str, int, bool]:
        words = [sys.executable, "-m", name, "--help"]
        said = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=False)
        return name, said.returncode, said.stdout.lower().lstrip().startswith("usage")

    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(asked, [name for name, _ in listed()]))
    assert len(found) > 40
    assert [each for each in found if each[1:] != (0, True)] == []
