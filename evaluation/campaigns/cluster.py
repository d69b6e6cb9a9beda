"""Trials on a Dask cluster: a worker that dies, freezes or slows down loses no trial, and no trial counts
twice.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.evaluation.campaigns.data.trial import Trial, died
from handcart.evaluation.campaigns.data.trial_log import line_of, trial_of
from handcart.files.errors import HandcartError, InputError
from handcart.networks.task.task_file import load_task

from .campaign_files import checksums
from .campaign_setting import CampaignSetting
from .scheduler_check import NoCluster, check_scheduler
from .trial_run import run_beside
from .workers import TrialFault, sendable

if TYPE_CHECKING:
    from distributed import Client, Future

Work = Callable[[int], bytes]
"""Function that runs the trial of a seed on a worker, and returns its line as `line_of` does."""
ANSWERS_S = 10.0
"""Time-out of a scheduler's answer, and of its first worker, in [s]."""
PATIENCE_S = 5.0
"""Minimum time before a trial under way is given to a second worker, in [s]."""
LATE_TIME_RATIO = 3.0
"""Minimum time before a trial under way is given to a second worker, in mean times of a trial."""
MAX_WORKERS_PER_TRIAL = 4
"""Maximum number of workers to which one trial is given, one after the other."""
TRIALS_PER_THREAD = 2
"""Number of trials that each thread of a worker has, including the running one."""
LOOKS_S = 2.0
"""Time between two checks of which workers are available, in [s]."""
NAPS_S = 0.005
"""Time between two checks of which trials have ended, in [s]."""
_ALONE = threading.Lock()  # a process runs one trial at a time: libraries are set up for all its threads

_CHECKED: list[TrialThere] = []
"""Trials whose files this worker has compared with the sender's."""


class ClusterLost(HandcartError):
    """Error for a Dask scheduler that stopped answering; trials that have ended are on disk."""

    def __init__(self, address: str) -> None:
        super().__init__(f"the scheduler {address} is gone; the same command runs the remaining trials")


class OtherFiles(InputError):
    """Error for a worker on which files of the campaign differ from those on the client."""


@dataclass(frozen=True)
class TrialThere:
    """Function that runs a trial on a worker of a cluster, if its files are those of the client.

    The worker needs the files at the same paths as the client.
    """

    setting: CampaignSetting
    files: Mapping[str, str]

    @classmethod
    def of(cls, setting: CampaignSetting) -> TrialThere:
        """Create the function that runs a campaign's trials on a cluster.

        It contains the checksums of the files on this machine, to which a worker compares its own files.

        Raises:
            FileError: a file is invalid.
        """
        faults = None if setting.faults is None else setting.faults.absolute()
        there = replace(setting, task=setting.task.absolute(), runs=setting.runs.absolute(), faults=faults)
        return cls(there, _files(there))

    def __call__(self, seed: int) -> bytes:
        """Run the trial of a seed.

        Raises:
            TrialFault: the trial cannot be run.
        """
        try:
            with _ALONE:
                self._check()
                return line_of(run_beside(self.setting, seed))
        except Exception as error:
            raise sendable(error) from None

    def _check(self) -> None:
        if self in _CHECKED:
            return
        here = _files(self.setting)
        wrong = [name for name in {**self.files, **here} if self.files.get(name) != here.get(name)]
        if wrong:
            raise OtherFiles(f"a worker has another content in {', '.join(sorted(wrong))}; needed: the same")
        _CHECKED.append(self)


def _files(setting: CampaignSetting) -> Mapping[str, str]:
    return checksums(setting, load_task(setting.task, setting.settings))


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the library's messages to programmers about lost connections."""
    handlers = list(logging.getLogger("distributed").handlers)
    before = [handler.level for handler in handlers]
    for handler in handlers:
        handler.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for handler, level in zip(handlers, before, strict=True):
            handler.setLevel(level)


@dataclass
class SubmittedTrial:
    """Trial of a campaign that was submitted to a Dask scheduler, with submission time and awaited
    results.
    """

    since: float
    futures: list[Future[bytes]] = field(default_factory=list)


class Cluster:
    """Runner of trials on the workers of a Dask scheduler.

    If the caller of `trials` stops iterating early, the remaining trials are cancelled.
    """

    def __init__(self, work: Work, address: str) -> None:
        """Prepare without contacting the scheduler; iterating does.

        Args:
            work: picklable function; handcart is installed on the workers.
            address: such as `tcp://10.0.0.1:8786`, or the path of a scheduler's file.
        """
        self._work, self._address = work, address
        self._left: Iterator[int] = iter(())
        self._over = False
        """True once each seed has been given to a worker."""
        self._asked: dict[int, SubmittedTrial] = {}
        self._seeds: dict[Any, int] = {}
        """Seeds by the key of their future."""
        self._took, self._ended = 0.0, 0
        self._looked, self._room = 0.0, 0

    def trials(self, seeds: Iterable[int]) -> Generator[list[Trial], None, None]:
        """Run a trial for each seed; yield lists of the trials that have ended since the last list.

        Raises:
            NoCluster: the scheduler does not answer.
            ClusterLost: the scheduler stopped answering.
            TrialFault: a trial cannot be run.
        """
        from distributed import as_completed

        self._left = iter(seeds)
        with _quiet(), self._client() as client:
            waiting = as_completed(loop=client.loop, with_results=True, raise_errors=False)
            try:
                while self._give(client, waiting):
                    if done := self._taken(client, waiting.next_batch(False)):
                        yield done
                    else:
                        time.sleep(NAPS_S)
            except OSError:
                raise ClusterLost(self._address) from None
            finally:
                with suppress(OSError):
                    client.cancel([future for asked in self._asked.values() for future in asked.futures])

    @contextmanager
    def _client(self) -> Iterator[Client]:
        from distributed import Client

        named = {"address": self._address} if "://" in self._address else {"scheduler_file": self._address}
        if "address" not in named and not Path(self._address).is_file():
            words = "no such file; allowed: an address such as tcp://10.0.0.1:8786, or a scheduler's file"
            raise NoCluster(f"--cluster {self._address}: {words}")
        check_scheduler(self._address, ANSWERS_S)
        try:
            client = Client(**named, timeout=ANSWERS_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise NoCluster(f"--cluster {self._address}: no scheduler answers: {error}") from None
        with client:
            try:
                client.wait_for_workers(1, timeout=ANSWERS_S)
            except TimeoutError:
                raise NoCluster(f"--cluster {self._address}: the scheduler has no workers") from None
            yield client

    def _give(self, client: Client, waiting: Any) -> bool:
        """Submit as many trials as the workers can take, and return whether any trial is pending."""
        if time.monotonic() - self._looked > LOOKS_S:
            self._looked = time.monotonic()
            self._room = TRIALS_PER_THREAD * sum(client.nthreads().values())
            if self._over:
                self._give_again(client, waiting)
        while not self._over and len(self._asked) < self._room:
            seed = next(self._left, None)
            if seed is None:
                self._over = True
            else:
                self._asked[seed] = SubmittedTrial(time.monotonic())
                self._submit(client, waiting, seed, None)
        return bool(self._asked) or not self._over

    def _give_again(self, client: Client, waiting: Any) -> None:
        """Give late trials to idle workers as well, because their worker is dead, frozen or slow."""
        idle = [worker for worker, keys in client.processing().items() if not keys]
        most = max(PATIENCE_S, LATE_TIME_RATIO * self._took / max(1, self._ended))
        for seed, asked in self._asked.items():
            if idle and len(asked.futures) < MAX_WORKERS_PER_TRIAL and time.monotonic() - asked.since > most:
                asked.since = time.monotonic()
                self._submit(client, waiting, seed, idle.pop())

    def _submit(self, client: Client, waiting: Any, seed: int, worker: str | None) -> None:
        future = client.submit(self._work, seed, workers=worker, allow_other_workers=bool(worker), pure=False)
        self._asked[seed].futures.append(future)
        self._seeds[future.key] = seed
        waiting.add(future)

    def _taken(self, client: Client, batch: Iterable[tuple[Future[bytes], Any]]) -> list[Trial]:
        """Return the first result of each trial."""
        done = []
        for future, result in batch:
            seed = self._seeds.pop(future.key)
            if seed not in self._asked:
                continue
            done.append(self._trial(future.status, result, seed))
            asked = self._asked.pop(seed)
            self._took += time.monotonic() - asked.since
            self._ended += 1
            if others := [future_ for future_ in asked.futures if future_.key != future.key]:
                client.cancel(others)
        return done

    def _trial(self, status: str | None, result: Any, seed: int) -> Trial:
        from distributed import KilledWorker

        if status == "finished":
            trial = trial_of(result)
            if trial is None or trial.seed != seed:
                raise TrialFault(f"the trial of seed {seed} came back with invalid content")
            return trial
        if status != "error":
            raise ClusterLost(self._address)
        error = result[1]
        if isinstance(error, KilledWorker):
            return died(seed, f"its worker died {error.allowed_failures + 1} times")
        raise sendable(error)
