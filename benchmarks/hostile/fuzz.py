"""Check damaged files: `python -m benchmarks.hostile.fuzz 10000 [SEED]`. Status 1 if one got no clear error.

Half of them are YAML files; half pictures, maps, URDFs and tables, within a limit of memory.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from benchmarks.damage.fuzzed_binaries import fuzz_binaries
from benchmarks.damage.fuzzed_files import Failure, fuzz
from handcart.tools.commands.check_file import check_quietly


def main() -> None:
    """Print progress, and each failure with the file that caused it."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("number", nargs="?", type=int, default=10_000)
    words.add_argument("seed", nargs="?", type=int, default=0)
    wanted = words.parse_args()
    count, seed = wanted.number, wanted.seed
    failures = 0
    with tempfile.TemporaryDirectory() as texts, tempfile.TemporaryDirectory() as binaries:
        tried: Iterator[Failure | None] = chain(
            fuzz_binaries(Path(binaries), count // 2, seed),
            fuzz(Path(texts), count - count // 2, check_quietly, seed),
        )
        for number, failure in enumerate(tried, start=1):
            if failure is not None:
                failures += 1
                kept = Path(tempfile.gettempdir()) / f"fuzz-{failure.number}-{failure.name}"
                kept.write_bytes(failure.content)
                print(f"\n{kept}: {failure.why}")
            if number % 50 == 0:
                print(f"\r{number} of {count}, {failures} failures", end="", flush=True)
    print(f"\r{count} damaged files, {failures} failures")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
