"""Attack the reading of a satellite receiver: `python -m benchmarks.hostile.gps_fuzz 1000000`.

Sound, damaged, random, repeated and late sentences, most with a right check sum. None may raise anything, and
no time of day may count twice, or after a later one. Exit status 1 if one did.
"""

from __future__ import annotations

import argparse
import sys

from benchmarks.damage.fuzzed_sentences import fuzzed_sentences


def main() -> None:
    """Print progress, and each failure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    sentences = fixes = failures = 0
    for number, account in enumerate(fuzzed_sentences(given.count, given.seed), start=1):
        sentences, fixes = sentences + account.sentences, fixes + account.fixes
        if account.wrong:
            failures += 1
            print(f"\nbehind {sentences} sentences: {account.wrong}")
        if number % 20 == 0:
            print(f"\r{sentences} sentences, {fixes} fixes, {failures} failures", end="", flush=True)
    print(f"\r{sentences} sentences, {fixes} fixes, {failures} failures")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
