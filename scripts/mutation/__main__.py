"""Draw mutants by a seed and report which the tests kill: `python scripts/mutation --drawn 20 --seed 1`.

The mutants are made by Cosmic Ray's operators, so nobody chose them. Each is tried on a copy of the project,
with the tests that execute its line (`--coverage`) or else those nearest to its file. More tests could kill
more of them, so the score is a lower bound. docs/reference/mutation.md.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts" / "mutants"))

from bed import TIMED_OUT, Bed  # noqa: E402
from choosing import MAX_FILES, nearest_tests, tests_by_coverage  # noqa: E402
from coverage import CoverageData  # noqa: E402
from drawing import MODULES, DrawnMutant, draw  # noqa: E402
from equivalent import TABLE, key_of, read_equivalents  # noqa: E402

PATIENCE_S = 180.0
NO_TESTS = 5  # pytest's exit status where it found none
BLAMED = re.compile(r"^(?:FAILED|ERROR) (\S+?\.py(?:::\w+)*)", re.MULTILINE)


@dataclass(frozen=True)
class Verdict:
    """What became of one mutant."""

    mutant: DrawnMutant
    word: str
    """killed, timed out, SURVIVED or equivalent."""
    blamed: tuple[str, ...] = ()
    """Tests that failed, as pytest takes them."""
    reason: str = ""

    def __str__(self) -> str:
        found = f"{self.word:<10} {self.mutant.file}:{self.mutant.line}"
        if self.word == "killed":
            return f"{found} by {' '.join(self.blamed)}"
        return "\n".join([f"{found} {self.reason}".rstrip(), *(f"      {x}" for x in _diff(self.mutant))])


def main() -> int:
    """Print each mutant and the score; 1: fewer than `--least` % are killed, 2: tests fail without any."""
    wanted = _arguments()
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        beds = [Bed(wanted.project, Path(folder) / str(job), {}) for job in range(wanted.jobs)]
        verdicts = []
        for verdict in _verdicts(wanted, beds):
            verdicts.append(verdict)
            print(f"{len(verdicts):>4}/{wanted.drawn} {verdict}", flush=True)
            if time.monotonic() - begun > 60.0 * wanted.minutes:
                break
        blamed = sorted({name for verdict in verdicts for name in verdict.blamed})
        if blamed and not beds[0].passes(tuple(blamed)):
            print(f"fails without any mutant, one of: {' '.join(blamed)}")
            return 2
    return _report(verdicts, wanted.seed, wanted.least)


def _report(verdicts: Sequence[Verdict], seed: str, least: float) -> int:
    count = {word: sum(each.word == word for each in verdicts) for word in ("timed out", "equivalent")}
    tried = len(verdicts) - count["equivalent"]
    killed = sum(each.word in ("killed", "timed out") for each in verdicts)
    share = 100.0 * killed / max(1, tried)
    print(
        f"{len(verdicts)} mutants drawn with seed {seed}: {killed} of {tried} killed ({share:.1f} %), "
        f"{count['timed out']} of them timed out; {count['equivalent']} equivalent"
    )
    return int(share < least)


def _verdicts(wanted: argparse.Namespace, beds: Sequence[Bed]) -> Iterator[Verdict]:
    free: SimpleQueue[Bed] = SimpleQueue()
    for bed in beds:
        free.put(bed)
    equivalents, data = read_equivalents(wanted.equivalent), CoverageData(str(wanted.coverage or ""))
    if wanted.coverage:
        data.read()

    def judge(mutant: DrawnMutant) -> Verdict:
        if key_of(mutant) in equivalents:
            return Verdict(mutant, "equivalent", reason=equivalents[key_of(mutant)])
        bed = free.get()
        try:
            return _try(bed, _with_tests(wanted, data, mutant))
        finally:
            free.put(bed)

    mutants = draw(wanted.project, wanted.seed, wanted.modules)
    with ThreadPoolExecutor(len(beds)) as pool:
        for _ in range(0, wanted.drawn, len(beds)):
            batch = [mutant for _, mutant in zip(beds, mutants, strict=False)]
            yield from pool.map(judge, batch)


def _with_tests(wanted: argparse.Namespace, data: CoverageData, mutant: DrawnMutant) -> DrawnMutant:
    tests = tests_by_coverage(wanted.project, data, mutant.file, mutant.line) if wanted.coverage else []
    tests = tests or nearest_tests(wanted.project, mutant.file)
    return replace(mutant, tests=tuple(tests[: wanted.files]))


def _try(bed: Bed, mutant: DrawnMutant) -> Verdict:
    if not mutant.tests:
        return Verdict(mutant, "SURVIVED", reason="no tests")
    ended = bed.run_tests(mutant, PATIENCE_S)
    if ended.status == TIMED_OUT:
        return Verdict(mutant, "timed out")
    if ended.status in (0, NO_TESTS):
        return Verdict(mutant, "SURVIVED", reason=f"{len(mutant.tests)} files of tests")
    return Verdict(mutant, "killed", tuple(BLAMED.findall(ended.output)) or mutant.tests)


def _diff(mutant: DrawnMutant) -> list[str]:
    return [line[:1] + " " + line[1:].strip() for line in mutant.name.splitlines()]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drawn", type=int, default=20, help="how many mutants")
    parser.add_argument("--seed", default="0", help="any text, e.g. the hash of a commit")
    parser.add_argument("--least", type=float, default=0.0, help="share in percent that has to be killed")
    parser.add_argument("--modules", nargs="+", choices=MODULES, default=list(MODULES), metavar="MODULE")
    parser.add_argument("--minutes", type=float, default=1e9, help="draw no further mutant after these")
    parser.add_argument("--files", type=int, default=MAX_FILES, help="files of tests for one mutant")
    parser.add_argument("--coverage", type=Path, help="data file of coverage.py, with contexts of tests")
    parser.add_argument("--jobs", type=int, default=1, help="copies of the project to work in")
    parser.add_argument("--project", type=Path, default=ROOT)
    parser.add_argument("--equivalent", type=Path, default=TABLE)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
