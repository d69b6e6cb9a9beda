"""Draw mutants by a seed and report which the tests kill: `python scripts/mutation --drawn 20 --seed 1`.

The mutants are made by Cosmic Ray's operators, not by hand. Each is tried on a copy of the project:
with the tests that execute its line, by a recording (`--record`, then `--coverage`), or else with those
nearest to its file. More tests could kill more of them, so the score is a lower bound.
docs/reference/mutation.md.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from queue import SimpleQueue
from threading import Lock

REPOSITORY_ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(REPOSITORY_ROOT / "scripts" / "mutants"))

from choosing import MAX_FILES, ChosenTests, choose_tests  # noqa: E402
from drawing import MODULE_GROUPS, DrawnMutant, draw  # noqa: E402
from equivalent import EQUIVALENT_FILE, key_of, read_equivalents  # noqa: E402
from recording import durations_of, read_recording, record  # noqa: E402
from warm_bed import UNSOUND, WarmBed  # noqa: E402

TIMEOUT_S = 60.0


@dataclass(frozen=True)
class Verdict:
    """Result of one mutant."""

    mutant: DrawnMutant
    word: str
    """killed, timed out, SURVIVED or equivalent."""
    blamed: tuple[str, ...] = ()
    """Tests that failed or never ended, as pytest takes them."""
    reason: str = ""

    def __str__(self) -> str:
        found = f"{self.word:<10} {self.mutant.file}:{self.mutant.line}"
        if self.word == "killed":
            return f"{found} by {' '.join(self.blamed) or 'an end without any test'}"
        return "\n".join([f"{found} {self.reason}".rstrip(), *(f"      {x}" for x in _diff(self.mutant))])


def main() -> int:
    """Print each mutant and the score; 1: fewer than `--least` % are killed. `--record` runs the suite."""
    wanted = _arguments()
    if wanted.record:
        return record(wanted.project, wanted.record, wanted.jobs)
    durations = durations_of(wanted.coverage.resolve()) if wanted.coverage else None
    with tempfile.TemporaryDirectory() as folder:
        beds = [WarmBed(wanted.project, Path(folder) / str(job), durations) for job in range(wanted.jobs)]
        try:
            verdicts = _print_all(wanted, beds)
            verdicts = _confirmed(verdicts, beds[0])
        finally:
            for bed in beds:
                bed.close()
    return _report(verdicts, wanted.seed, wanted.least)


def _print_all(wanted: argparse.Namespace, beds: Sequence[WarmBed]) -> list[Verdict]:
    begun, verdicts = time.monotonic(), []
    for verdict in _verdicts(wanted, beds):
        verdicts.append(verdict)
        print(f"{len(verdicts):>4}/{wanted.drawn} {verdict}", flush=True)
        if time.monotonic() - begun > 60.0 * wanted.minutes:
            break
    return verdicts


def _confirmed(verdicts: Sequence[Verdict], bed: WarmBed) -> list[Verdict]:
    """Return the verdicts; a mutant whose tests fail without it, too, has survived."""
    failing = bed.failing(sorted({name for verdict in verdicts for name in verdict.blamed}))
    confirmed = []
    for verdict in verdicts:
        if verdict.blamed and failing.issuperset(verdict.blamed):
            verdict = replace(
                verdict, word="SURVIVED", reason=f"fails without it: {' '.join(verdict.blamed)}"
            )
            print(f"     {verdict}", flush=True)
        confirmed.append(verdict)
    return confirmed


def _report(verdicts: Sequence[Verdict], seed: str, least: float) -> int:
    count = {word: sum(verdict.word == word for verdict in verdicts) for word in ("timed out", "equivalent")}
    tried = len(verdicts) - count["equivalent"]
    killed = sum(verdict.word in ("killed", "timed out") for verdict in verdicts)
    share = 100.0 * killed / max(1, tried)
    print(
        f"{len(verdicts)} mutants drawn with seed {seed}: {killed} of {tried} killed ({share:.1f} %), "
        f"{count['timed out']} of them timed out; {count['equivalent']} equivalent"
    )
    return int(share < least)


def _verdicts(wanted: argparse.Namespace, beds: Sequence[WarmBed]) -> Iterator[Verdict]:
    free: SimpleQueue[WarmBed] = SimpleQueue()
    for bed in beds:
        free.put(bed)
    equivalents, recording = read_equivalents(wanted.equivalent), read_recording(wanted.coverage)

    def judge(mutant: DrawnMutant) -> Verdict:
        if key_of(mutant) in equivalents:
            return Verdict(mutant, "equivalent", reason=equivalents[key_of(mutant)])
        with choosing:
            tests = choose_tests(
                beds[0].root, recording, mutant.file, mutant.line, wanted.seconds, wanted.files
            )
        bed = free.get()
        try:
            return _try(bed, mutant, tests, wanted.seconds)
        finally:
            free.put(bed)

    choosing = Lock()
    mutants = draw(wanted.project, wanted.seed, wanted.modules)
    with ThreadPoolExecutor(len(beds)) as pool:
        yield from pool.map(judge, islice(mutants, wanted.drawn))


def _try(bed: WarmBed, mutant: DrawnMutant, tests: ChosenTests, seconds: float) -> Verdict:
    if not tests.tests and not tests.files:
        return Verdict(mutant, "SURVIVED", reason="no tests")
    answer = bed.try_mutant(mutant, tests, seconds)
    if answer.word == "hung":
        return Verdict(mutant, "timed out", answer.blamed, f"in {' '.join(answer.blamed)}")
    if answer.word == "failed":
        return Verdict(mutant, "killed", answer.blamed)
    if answer.word == UNSOUND:
        return Verdict(mutant, "SURVIVED", reason="its tests do not pass in time without it")
    chosen = f"{len(tests.tests)} are known to execute it" if tests.executing else "of the nearest files"
    return Verdict(mutant, "SURVIVED", reason=f"{answer.ran} tests ran; {chosen}")


def _diff(mutant: DrawnMutant) -> list[str]:
    return [line[:1] + " " + line[1:].strip() for line in mutant.name.splitlines()]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drawn", type=int, default=20, help="how many mutants")
    parser.add_argument("--seed", default="0", help="any text, e.g. the hash of a commit")
    parser.add_argument("--least", type=float, default=0.0, help="share in percent that has to be killed")
    parser.add_argument(
        "--modules", nargs="+", choices=MODULE_GROUPS, default=list(MODULE_GROUPS), metavar="MODULE"
    )
    parser.add_argument("--minutes", type=float, default=1e9, help="draw no further mutant after these")
    parser.add_argument("--record", type=Path, help="run the quick suite once and write this file instead")
    parser.add_argument("--coverage", type=Path, help="what `--record` wrote: which test executes which line")
    parser.add_argument("--seconds", type=float, default=TIMEOUT_S, help="of tests for one mutant")
    parser.add_argument("--files", type=int, default=MAX_FILES, help="files of tests where no test is known")
    parser.add_argument("--jobs", type=int, default=1, help="copies of the project to work in")
    parser.add_argument("--project", type=Path, default=REPOSITORY_ROOT)
    parser.add_argument("--equivalent", type=Path, default=EQUIVALENT_FILE)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
