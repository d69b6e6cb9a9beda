"""A sample of the attacks that `python -m benchmarks.hostile.hostile_folders` makes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.slow
def test_attacked_folders_run_nothing_touch_nothing_and_end_in_words() -> None:
    attack = ["benchmarks.hostile.hostile_folders", "--folders", "60", "--of", "first block"]
    said = subprocess.run(
        [sys.executable, "-m", *attack],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (said.returncode, "60 folders, 0 violations" in said.stdout) == (0, True), (
        said.stdout + said.stderr
    )
