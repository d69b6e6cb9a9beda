"""Processes that run trials in parallel; a process that dies loses no trial."""

from __future__ import annotations

import signal
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import suppress
from itertools import chain, islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.connection import wait as wait_for
from multiprocessing.process import BaseProcess

from handcart.evaluation.campaigns.data.trial import Trial, died
from handcart.evaluation.trials.with_parent import end_with_parent
from handcart.files.errors import HandcartError

Work = Callable[[int], Trial]
"""Function that runs the trial of a seed."""
TOGETHER_S = 0.02
"""Time over which short trials are collected before they are sent, in [s]."""
AHEAD_S = 0.1
"""Amount of work that a process has in its queue, in [s]; at least the trial that it runs."""
MOST_AHEAD = 256
MAX_PROCESS_DEATHS = 5
"""Number of deaths of the process during one trial after which that counts as the trial's end."""
MAX_FAILED_STARTS = 20
"""Number of processes in a row that end before they begin, after which the campaign ends."""


class TrialFault(HandcartError):
    """Error for a trial that cannot be run, with the text and exit status of the error that prevented it."""

    def __init__(self, words: str, exit_status: int = 5) -> None:
        super().__init__(words)
        self.exit_status = exit_status  # type: ignore[misc]


class Worker:
    """Worker process that runs trials, with the queue of seeds whose results it still has to send."""

    def __init__(self, work: Work) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.seeds: deque[int] = deque()
        self.begun = False
        """True once the process has begun to work."""
        self.process: BaseProcess = context.Process(target=_serve, args=(theirs, work), daemon=True)
        self.process.start()
        theirs.close()

    def give(self, seeds: list[int]) -> None:
        """Append seeds to the worker's queue; if the worker has died, the next call of `taken` reports it."""
        self.seeds.extend(seeds)
        with suppress(OSError):
            self.connection.send(seeds)

    def taken(self) -> list[Trial] | None:
        """Wait for the worker's next message; return the trials in it, and take their seeds off the queue.

        None if the process has ended.

        Raises:
            HandcartError: a trial cannot be run.
        """
        try:
            said: list[Trial] | Exception = self.connection.recv()
        except (EOFError, OSError):
            return None
        if isinstance(said, Exception):
            raise said
        self.begun = True
        for item in said:
            self.seeds.remove(item.seed)
        return said


class Workers:
    """Runner of trials in parallel processes, which end if the caller of `trials` stops iterating early."""

    def __init__(self, work: Work, jobs: int) -> None:
        """Prepare without starting a process; iterating does.

        Args:
            work: picklable function.
            jobs: number of processes.
        """
        self._work, self._jobs = work, jobs
        self._workers: list[Worker] = []
        self._deaths: Counter[int] = Counter()
        self._took, self._first, self._ended, self._stillborn = 0.0, 0.0, 0, 0
        self._left: Iterator[int] = iter(())

    def trials(self, seeds: Iterable[int]) -> Generator[list[Trial], None, None]:
        """Run a trial for each seed; yield lists of the trials that have ended since the last list.

        Raises:
            HandcartError: a trial cannot be run.
        """
        self._left = iter(seeds)
        try:
            while self._busy():
                waits = {worker_.connection: worker_ for worker_ in self._workers}
                for connection in wait_for(list(waits)):
                    assert isinstance(connection, Connection)
                    worker = waits[connection]
                    done = worker.taken()
                    if done is None:
                        done = self._buried(worker)
                    elif done:
                        self._stillborn = 0
                        self._clock(len(done))
                        self._feed(worker)
                    if done:
                        yield done
        except BaseException:
            self._end()
            raise
        self._let_go()

    def _clock(self, ended: int) -> None:
        """Update the duration of a trial from the number that have ended; the first ones, which started late,
        are excluded.
        """
        now = time.monotonic()
        if not self._first:
            self._first = now
            return
        self._ended += ended
        self._took = (now - self._first) * len(self._workers) / self._ended

    def _busy(self) -> bool:
        """Give work to as many processes as are useful; return True while any trial is pending."""
        self._workers = [worker_ for worker_ in self._workers if worker_.seeds or self._feed(worker_)]
        while len(self._workers) < self._jobs:
            first = next(self._left, None)
            if first is None:
                break
            worker = Worker(self._work)
            self._workers.append(worker)
            worker.give([first])
        return bool(self._workers)

    def _feed(self, worker: Worker) -> bool:
        """Fill the queue of a worker, and return whether it has anything to do."""
        ahead = min(MOST_AHEAD, int(AHEAD_S / self._took)) if self._took else 0
        more = list(islice(self._left, max(0, 1 + ahead - len(worker.seeds))))
        if more:
            worker.give(more)
        elif not worker.seeds:
            _let_go(worker)
        return bool(worker.seeds)

    def _buried(self, worker: Worker) -> list[Trial]:
        """Give the trials of a dead worker to others; a trial that kills each of its workers has ended."""
        self._workers.remove(worker)
        worker.process.join()
        first = worker.seeds[0]
        self._deaths[first] += worker.begun
        self._stillborn += not worker.begun
        if self._stillborn > MAX_FAILED_STARTS:
            raise TrialFault(f"processes die before they begin, at last {_how(worker.process)}")
        if self._deaths[first] < MAX_PROCESS_DEATHS:
            self._left = chain(worker.seeds, self._left)
            return []
        worker.seeds.popleft()
        self._left = chain(worker.seeds, self._left)
        return [died(first, f"its process died {MAX_PROCESS_DEATHS} times, at last {_how(worker.process)}")]

    def _let_go(self) -> None:
        for worker in self._workers:
            _let_go(worker)

    def _end(self) -> None:
        end([worker.process for worker in self._workers])


def end(processes: Iterable[BaseProcess]) -> None:
    """Ask worker processes to end, again and again until all have ended.

    One request may not be enough: it ends a running trial, which first stops its robot, but the process may
    already begin the next trial. An interrupt during this function kills the processes.
    """
    alive = list(processes)
    try:
        while alive := [base_process for base_process in alive if base_process.is_alive()]:
            for process in alive:
                process.terminate()
            wait_for([base_process.sentinel for base_process in alive], timeout=0.5)
    finally:
        for process in alive:
            process.kill()


def _let_go(worker: Worker) -> None:
    worker.connection.close()
    worker.process.join(5.0)
    if worker.process.is_alive():  # its output is complete; a library's thread does not end
        worker.process.kill()


def _how(process: BaseProcess) -> str:
    code = process.exitcode or 0
    return f"by signal {-code}" if code < 0 else f"with status {code}"


def _serve(connection: Connection, work: Work) -> None:
    """Loop of a worker process: run received seeds and send ended trials, until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it comes to all of a terminal's processes; one is enough
    end_with_parent()
    try:
        _run_all(connection, work)
    except (EOFError, OSError, KeyboardInterrupt):
        return
    except Exception as error:
        connection.send(sendable(error))


def _run_all(connection: Connection, work: Work) -> None:
    seeds: deque[int] = deque()
    done: list[Trial] = []
    connection.send(done)  # here it begins
    sent = time.monotonic()
    while True:
        while not seeds or connection.poll():
            seeds.extend(connection.recv())
        trial = work(seeds.popleft())
        if trial.signalled:
            return
        done.append(trial)
        if not seeds or time.monotonic() - sent > TOGETHER_S:
            connection.send(done)
            done, sent = [], time.monotonic()


def sendable(error: Exception) -> TrialFault:
    """Return an error that can be pickled, with the text of the original one."""
    if isinstance(error, TrialFault):
        return error
    if isinstance(error, HandcartError):
        return TrialFault(str(error), error.exit_status)
    return TrialFault(f"{type(error).__name__}: {error}")
