"""Attack simulated drives' bus: `python -m benchmarks.hostile.can_fuzz --frames 100000 --setups 1000`.

Random, damaged and repeated frames while drives are set up, enabled, driven, stopped and left. Whatever they
are, the program may raise nothing but a `CanFault`, and after one no drive may be in OPERATION ENABLED, or
move. Exit status 1 if one was.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections import Counter

from benchmarks.damage.fuzzed_bus import attacks


def main() -> None:
    """Print progress, and each failure with what reproduces it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=100_000, help="at least so many")
    parser.add_argument("--setups", type=int, default=1000, help="at least so many")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    logging.disable(logging.CRITICAL)  # the library logs each frame that it can't read
    frames, ends, failures, number = 0, Counter[str](), 0, 0
    for number, attack in enumerate(attacks(given.setups, given.frames, given.seed), start=1):
        frames += attack.frames
        ends["faults" if attack.fault else "went on"] += 1
        if attack.wrong:
            failures += 1
            print(f"\nset-up {attack.number}, noise in {attack.phase}, {attack.fault!r}:\n{attack.wrong}")
        if number % 20 == 0:
            print(f"\r{number} set-ups, {frames} frames, {failures} failures", end="", flush=True)
    counts = ", ".join(f"{count} {what}" for what, count in sorted(ends.items()))
    print(f"\r{number} set-ups ({counts}), {frames} frames, {failures} failures")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
