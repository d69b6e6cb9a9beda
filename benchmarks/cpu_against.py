"""Print the CPU time of runs and starts in this checkout over another: the row of issues on speed.

    python -m benchmarks.cpu_against CHECKOUT [TASK ...] [--pairs 5] [--starts 3] [--seed 1]

The other checkout's code runs in its `.venv`, or in this one's if it has none. One process of each imports
and compiles in a first run, which is not counted; then both run each task with the same seed, in turn,
`--pairs` times, the first of a pair being the second of the next. `start` is a campaign of one trial less
the median run. Counted is user and system time on one thread. `ratio` is the median of the pairs' ratios,
`from` and `to` are the least and the greatest, `of least` divides the least times, which load on the
machine raises least.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rich.console import Console
from rich.progress import Progress

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
TASK_NAMES = ("return_book", "stack_blocks", "track_seam", "deploy_straight")
RUN_ON_REQUEST = """
import os, sys, tempfile, time
from pathlib import Path
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.trial_run import run_beside

answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)
with tempfile.TemporaryDirectory() as folder:
    setting = CampaignSetting(Path(sys.argv[1]), backend=sys.argv[2], runs=Path(folder))
    for line in sys.stdin:
        before = time.process_time()
        run_beside(setting, int(line))
        print(time.process_time() - before, file=answers, flush=True)
"""
"""Program of a process that executes a run for each seed it reads, and answers with the CPU time [s].

It is started in either checkout, so that it uses only names that both have.
"""


class Row(NamedTuple):
    """CPU times of one thing in both checkouts, pair by pair [s]."""

    name: str
    here: list[float]
    other: list[float]

    def text(self) -> str:
        """Return the line of the table."""
        ratios = [here / other for here, other in zip(self.here, self.other, strict=True)]
        least = min(self.here) / min(self.other)
        return (
            f"{self.name:24}{len(ratios):6}{median(self.here):9.3f}{median(self.other):9.3f}"
            f"{median(ratios):8.3f}{min(ratios):8.3f}{max(ratios):8.3f}{least:10.3f}"
        )


def python_of(checkout: Path) -> str:
    """Return the interpreter of a checkout's virtual environment; this one's if it has none."""
    own = checkout / ".venv" / "bin" / "python"
    return str(own) if checkout != REPOSITORY_ROOT and own.exists() else sys.executable


def environment_of(checkout: Path, **more: str) -> dict[str, str]:
    """Return the variables of a process that runs a checkout's code, on one thread."""
    return {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(checkout / "src"), **more}


@contextmanager
def runner(checkout: Path, task: str, backend: str) -> Iterator[Callable[[int], float]]:
    """Yield a function that runs a task with a seed by a checkout's code and returns the CPU time [s]."""
    words = [python_of(checkout), "-P", "-c", RUN_ON_REQUEST, f"tasks/{task}/task.yaml", backend]
    pipe = subprocess.PIPE
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(
            words,
            cwd=checkout,
            stdin=pipe,
            stdout=pipe,
            stderr=errors,
            text=True,
            env=environment_of(checkout),
        )
        assert process.stdin is not None and process.stdout is not None
        requests, answers = process.stdin, process.stdout

        def run(seed: int) -> float:
            print(seed, file=requests, flush=True)
            answer = answers.readline()
            if not answer:
                errors.seek(0)
                raise RuntimeError(f"{checkout}: {task}, seed {seed}: {errors.read()[-2000:]}")
            return float(answer)

        try:
            yield run
        finally:
            process.kill()
            process.communicate()


def start_s(checkout: Path, words: list[str]) -> float:
    """Return the CPU time of one `handcart` with these words by a checkout's code, in [s]."""
    program = f"from handcart.tools.main import main; main({words!r})"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [python_of(checkout), "-P", "-c", program],
            cwd=checkout,
            env=environment_of(checkout, TMPDIR=folder),
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def alternated(
    name: str, functions: Sequence[Callable[[], float]], count: int, advance: Callable[[], None]
) -> Row:
    """Measure both functions in turn, each pair in the opposite order of the last."""
    times: list[list[float]] = [[], []]
    for pair in range(count):
        for side in (0, 1) if pair % 2 == 0 else (1, 0):
            times[side].append(functions[side]())
            advance()
    return Row(name, *times)


def rows_of_task(
    checkouts: list[Path], task: str, given: argparse.Namespace, advance: Callable[[], None]
) -> Iterator[Row]:
    """Yield the row of a task's run, then that of its start."""
    with ExitStack() as stack:
        runs = [stack.enter_context(runner(checkout, task, given.backend)) for checkout in checkouts]
        for run in runs:
            run(given.seed)
            advance()
        row = alternated(task, [partial(run, given.seed) for run in runs], given.pairs, advance)
    yield row
    words = ["campaign", f"tasks/{task}/task.yaml", "--trials", "1", "--jobs", "1"]
    words += ["--first", str(given.seed), "--backend", given.backend]
    starts = [partial(start_s, checkout, words) for checkout in checkouts]
    if given.starts:
        both = alternated(f"  start of {task}", starts, given.starts, advance)
        here = [start - median(row.here) for start in both.here]
        yield Row(both.name, here, [start - median(row.other) for start in both.other])


def main() -> None:
    """Print a row as soon as it is measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("checkout", type=Path, help="the other version, such as a clone of an earlier commit")
    parser.add_argument("tasks", nargs="*", default=TASK_NAMES, help="folders of tasks")
    parser.add_argument("--pairs", type=int, default=5, help="runs in each checkout")
    parser.add_argument("--starts", type=int, default=3, help="campaigns of one trial in each checkout")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--backend", default="kinematic")
    given = parser.parse_args()
    checkouts = [REPOSITORY_ROOT, given.checkout.resolve()]
    heads = ("here", "other")
    print(
        f"{'CPU s':24}{'pairs':>6}{heads[0]:>9}{heads[1]:>9}{'ratio':>8}{'from':>8}{'to':>8}{'of least':>10}"
    )
    steps = 2 * len(given.tasks) * (1 + given.pairs + given.starts)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("runs", total=steps)

        def advance() -> None:
            progress.advance(bar)

        for task in given.tasks:
            for row in rows_of_task(checkouts, task, given, advance):
                print(row.text(), flush=True)
    help_times = [partial(start_s, checkout, ["--help"]) for checkout in checkouts]
    if given.starts:
        print(alternated("handcart --help", help_times, 4 * given.starts, lambda: None).text(), flush=True)


if __name__ == "__main__":
    main()
