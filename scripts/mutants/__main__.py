"""Plant bugs one by one and report those that near tests miss: `python scripts/mutants --sample 20`."""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import TypeVar

from bed import Bed
from mutant import TABLE_FOLDER, Mutant, read_table

REPOSITORY_ROOT = Path(__file__).resolve().parents[2]
TABLE_ROWS = {"covariances": "planted constants for covariances"}
"""Words for the last line but one, by the file of the table that is chosen."""
T = TypeVar("T")


def main() -> int:
    """Print each bug and whether it was noticed; 1: too many were missed, 2: tests fail without any."""
    wanted = _arguments()
    table = read_table(wanted.table, f"{wanted.only or '*'}.yaml")
    mutants = [mutant for mutant in table if wanted.file in mutant.file and wanted.name in mutant.name]
    if wanted.sample:
        mutants = random.Random(wanted.seed).sample(mutants, min(wanted.sample, len(mutants)))
    took: dict[tuple[str, ...], float] = {}
    with tempfile.TemporaryDirectory() as folder:
        beds = [Bed(wanted.project, Path(folder) / str(job), took) for job in range(wanted.jobs)]
        return _try(mutants, wanted.least, beds, TABLE_ROWS.get(wanted.only, ""))


def _try(mutants: list[Mutant], least: float, beds: list[Bed], row: str = "") -> int:
    free: SimpleQueue[Bed] = SimpleQueue()
    for bed in beds:
        free.put(bed)
    with ThreadPoolExecutor(len(beds)) as pool:
        tests = sorted({mutant.tests for mutant in mutants})
        passes = pool.map(_in(free, Bed.passes), tests)
        red = [names for names, green in zip(tests, passes, strict=True) if not green]
        for names in red:
            print(f"fails without any bug: {' '.join(names)}")
        if red:
            return 2
        missed = list(_missed(mutants, pool.map(_in(free, Bed.notices), mutants)))
    if row:
        print(f"{row} ({len(mutants)} places) noticed: {len(mutants) - len(missed)}")
    share = 100 * (len(mutants) - len(missed)) / max(1, len(mutants))
    print(f"{len(mutants) - len(missed)} of {len(mutants)} planted bugs were noticed ({share:.1f} %)")
    return share < least


def _in(free: SimpleQueue[Bed], work: Callable[[Bed, T], bool]) -> Callable[[T], bool]:
    """Do the work in a free bed."""

    def borrowed(item: T) -> bool:
        bed = free.get()
        try:
            return work(bed, item)
        finally:
            free.put(bed)

    return borrowed


def _missed(mutants: list[Mutant], noticed: Iterator[bool]) -> Iterator[Mutant]:
    for number, (mutant, seen) in enumerate(zip(mutants, noticed, strict=True), 1):
        words = "noticed" if seen else "MISSED "
        print(f"{number:>4}/{len(mutants)} {words} {mutant.file}: {mutant.name}", flush=True)
        if not seen:
            yield mutant


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=0, help="so many, drawn by the seed; default: all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--least", type=float, default=100.0, help="share in percent that has to be noticed")
    parser.add_argument("--jobs", type=int, default=2, help="copies of the project to work in")
    parser.add_argument("--only", default="", help="only this file of the table, by its name: covariances")
    parser.add_argument("--file", default="", help="only files with this in their path")
    parser.add_argument("--name", default="", help="only bugs with this in their name")
    parser.add_argument("--project", type=Path, default=REPOSITORY_ROOT)
    parser.add_argument("--table", type=Path, default=TABLE_FOLDER, help="folder of YAML files")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
