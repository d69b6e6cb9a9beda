"""Check damaged files: `python -m benchmarks.fuzz 10000`. Exit status 1 if one got no clear error."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from evaluation.fuzzed_files import fuzz
from tools.check_file import check_quietly


def main() -> None:
    """Print progress, and each failure with the file that caused it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        for number, failure in enumerate(fuzz(Path(folder), count, check_quietly), start=1):
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
