"""`scripts/draw_docstrings.py` draws public docstrings by a seed, without their code."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "scripts" / "draw_docstrings.py"


def drawn(*words: str) -> list[str]:
    done = subprocess.run([sys.executable, SCRIPT, *words], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


@pytest.mark.slow
def test_draw_of_a_seed_is_always_the_same() -> None:
    one, again, other = drawn("--seed", "3"), drawn("--seed", "3"), drawn("--seed", "4")
    assert one == again
    assert one != other
    assert one[-1].startswith("60 of ")


@pytest.mark.slow
def test_draw_of_arrays_holds_only_functions_with_arrays() -> None:
    lines = drawn("--arrays", "--count", "25")
    titles = [line for line in lines if line[:1].isdigit() and ".py:" in line]
    assert len(titles) == 25
    assert all("Array" in title or "Transform" in title or "GreyImage" in title for title in titles)
    places = [title.split()[1].rsplit(":", 1) for title in titles]
    texts = {path: (ROOT / path).read_text(encoding="utf-8").splitlines() for path, _ in places}
    assert all("def " in texts[path][int(line) - 1] for path, line in places)
