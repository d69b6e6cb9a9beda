"""Damaged files get an error in words: no traceback, no hang, no file touched. Many: `benchmarks.fuzz`."""

from evaluation.fuzzed_files import fuzz
from tools.check_file import check_quietly


def test_damaged_files_are_told_in_words(tmp_path):
    failures = [each for each in fuzz(tmp_path, 150, check_quietly, seed=1) if each is not None]
    assert failures == []
