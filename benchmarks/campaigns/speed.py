"""Measure the time and memory that a campaign takes beside its trials.

    python -m benchmarks.campaigns.speed [--trials 100000]

The network alone, as a command, start included, and the page of 10,000 trials; trials of 50 ms on two
workers against the ideal: processes, two merged shards, a Dask scheduler; memory of many trials and their
report.

Started processes import this module once more, so large imports are made where they are used. The imports
of a trial itself are no cost of the campaign: they are printed apart.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.queues import SimpleQueue
from pathlib import Path

from benchmarks.campaigns.sleeper import SLEEPS_S, sleep, sleep_there
from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
from handcart.evaluation.campaigns.data.merging import merged
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import TrialLog
from handcart.evaluation.campaigns.workers import Workers

SLEEPER_COUNT = 1000


def overhead(path: Path, running: Iterable[list[Trial]]) -> tuple[float, float]:
    """Return the excess over the ideal time on two workers [%]: in all, and from the first trial on."""
    began = time.monotonic()
    first, ended = 0.0, 0
    with TrialLog(path) as log:
        for together in running:
            log.append(together)
            ended += len(together)
            if not first:
                first, before = time.monotonic(), ended
    end = time.monotonic()
    ideal = SLEEPER_COUNT * SLEEPS_S / 2
    rest = (SLEEPER_COUNT - before) * SLEEPS_S / 2
    return (end - began) / ideal - 1.0, (end - first) / rest - 1.0


def shards(folder: Path) -> tuple[float, float]:
    """Return the same excess for two shards, each with one worker, from their start until they are merged."""
    parts = [folder / f"part_{number}" for number in (1, 2)]
    spawned = multiprocessing.get_context("spawn")
    firsts = spawned.SimpleQueue()
    each = [spawned.Process(target=shard, args=(path, firsts)) for path in parts]
    began = time.monotonic()
    for process in each:
        process.start()
    for process in each:
        process.join()
    whole = merged(parts, folder / "whole")
    end = time.monotonic()
    if (count := len(whole.trials())) != SLEEPER_COUNT:
        raise RuntimeError(f"{count} trials are there; needed: {SLEEPER_COUNT}")
    first = max(firsts.get() for _ in parts)
    ideal = SLEEPER_COUNT * SLEEPS_S / 2
    return (end - began) / ideal - 1.0, (end - first) / (ideal - SLEEPS_S) - 1.0


def shard(folder: Path, firsts: SimpleQueue[float]) -> None:
    """Run the shard that the folder's name gives; report when its first trial has ended."""
    number = int(folder.name.removeprefix("part_"))
    made = CampaignFolder.made(folder, {"first": 0, "trials": SLEEPER_COUNT, "shard": f"{number}/2"})
    with made.log() as log:
        for together in Workers(sleep, 1).trials(range(SLEEPER_COUNT)[number - 1 :: 2]):
            if not len(log):
                firsts.put(time.monotonic())
            log.append(together)


def campaign(task: Path, trials: int, out: Path, jobs: int) -> float:
    """Seconds of wall time for a campaign of the network alone, as a command."""
    words = ["campaign", str(task), "--level", "network", "--trials", str(trials), "--jobs", str(jobs)]
    began = time.monotonic()
    subprocess.run(
        [sys.executable, "-m", "handcart", *words, "--out", str(out)],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return time.monotonic() - began


@contextmanager
def scheduler(folder: Path) -> Iterator[Path]:
    """Yield the file of a Dask scheduler with two workers."""
    from distributed import Client

    file = folder / "scheduler.json"
    where = ["--scheduler-file", str(file), "--no-dashboard", "--host", "127.0.0.1"]
    with ExitStack() as stack:
        stack.enter_context(dask("scheduler", "--port", "0", *where))
        while not file.exists():
            time.sleep(0.1)
        for _ in range(2):
            kept = ("--no-nanny", "--local-directory", str(folder))
            stack.enter_context(dask("worker", "--nthreads", "1", *kept, *where))
        with Client(scheduler_file=str(file), set_as_default=False) as client:  # type: ignore[no-untyped-call]
            client.wait_for_workers(2)
        yield file


@contextmanager
def dask(*words: str) -> Iterator[None]:
    """Yield a process of Dask's."""
    known = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen([sys.executable, "-m", "dask", *words], env=known, **quiet)  # type: ignore[call-overload]
    try:
        yield
    finally:
        process.kill()
        process.wait()


def tell(what: str, shares: tuple[float, float]) -> None:
    """Print an overhead."""
    whole, running = (100.0 * share for share in shares)
    print(
        f"{SLEEPER_COUNT} trials of 50 ms on 2 workers, {what}: "
        f"{whole:.2f} % more than ideal, start included,"
    )
    print(f"  {running:.2f} % once the first has ended")


def page(task: Path, out: Path, trials: int = 10_000) -> tuple[float, float]:
    """Return the page of a campaign of the network alone: its size in [MB], and seconds of CPU to write
    it.
    """
    from handcart.evaluation.campaigns.page.campaign_page import CampaignPage

    campaign(task, trials, out, 1)
    before = time.process_time()
    path = CampaignPage.of(out).write()
    return path.stat().st_size / 1e6, time.process_time() - before


def importing() -> float:
    """Seconds of CPU until a process has imported what a trial of a task needs."""
    code = "import time; import handcart.evaluation.trials.running; print(time.process_time())"
    return min(float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(3))


def main() -> None:
    """Measure and print."""
    from handcart.evaluation.campaigns.cluster import Cluster

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--trials", type=int, default=100_000)
    trials = parser.parse_args().trials
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        task = walk(folder)
        least = min(campaign(task, 1000, folder / f"small{number}", 1) for number in range(3))
        nothing = min(campaign(task, 1, folder / f"one{number}", 1) for number in range(3))
        print(f"1000 trials, network alone: {least:.2f} s, of which {nothing:.2f} s for a campaign of one")
        size, spent = page(task, folder / "page")
        print(f"page of 10000 trials: {size:.2f} MB, {spent:.2f} s of CPU")
        taken = campaign(task, trials, folder / "big", 1)
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
        print(f"{trials} trials, network alone: {taken:.1f} s, at most {peak:.0f} MiB")
        tell("processes", overhead(folder / "here", Workers(sleep, 2).trials(range(SLEEPER_COUNT))))
        tell("two shards, merged", shards(folder))
        print(f"a process has imported what a trial needs after {importing():.2f} s of CPU")
        with scheduler(folder) as file:
            tell(
                "Dask",
                overhead(folder / "there", Cluster(sleep_there, str(file)).trials(range(SLEEPER_COUNT))),
            )


if __name__ == "__main__":
    main()
