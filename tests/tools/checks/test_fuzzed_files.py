"""Damaged files get an error in words: no traceback, no hang, no gigabytes, no file touched.

Many: `benchmarks.hostile.fuzz`.
"""

from pathlib import Path

import pytest

from benchmarks.damage.fuzzed_binaries import fuzz_binaries
from benchmarks.damage.fuzzed_files import fuzz
from handcart.tools.commands.check_file import check_quietly


@pytest.mark.slow
def test_damaged_files_are_told_in_words(tmp_path: Path) -> None:
    failures = [failure for failure in fuzz(tmp_path, 60, check_quietly, seed=1) if failure is not None]
    assert failures == []


@pytest.mark.parametrize("seed", [1, 2])
def test_damaged_pictures_urdfs_and_tables_are_told_in_words(tmp_path: Path, seed: int) -> None:
    """T1, T2, T9: pipes and folders in their place, sizes of gigabytes, invalid numbers."""
    assert [binary for binary in fuzz_binaries(tmp_path, 60, seed) if binary is not None] == []
