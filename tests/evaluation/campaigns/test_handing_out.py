"""Assignment of trials to a cluster's workers, with a stub scheduler."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import distributed
import pytest

from handcart.evaluation.campaigns import cluster as module
from handcart.evaluation.campaigns.cluster import Cluster, ClusterLost
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.trial_log import line_of
from handcart.evaluation.campaigns.workers import TrialFault
from tests.conftest import Clock

WORKER: Any = None
"""The last worker that had a trial; the code under test does not read it."""


@dataclass(eq=False)
class Future:
    """A trial on its way."""

    seed: int
    worker: str | None
    key: str
    status: str = "finished"


@dataclass
class Scheduler:
    """Client and `as_completed` in one; `end` says what ends at the next look."""

    threads: dict[str, int]
    loop: None = None
    given: list[Future] = field(default_factory=list)
    cancelled: list[Future] = field(default_factory=list)
    idle: list[str] = field(default_factory=list)
    ended: list[tuple[Future, Any]] = field(default_factory=list)

    def nthreads(self) -> dict[str, int]:
        return self.threads

    def processing(self) -> dict[str, list[str]]:
        return {name: [] if name in self.idle else ["a trial"] for name in self.threads}

    def submit(self, work: Any, seed: int, workers: str | None, **more: bool) -> Future:
        assert more == {"allow_other_workers": workers is not None, "pure": False}
        self.given.append(Future(seed, workers, f"{seed}-{len(self.given)}"))
        return self.given[-1]

    def cancel(self, futures: list[Future]) -> None:
        self.cancelled += futures

    def add(self, future: Future) -> None:
        assert future is self.given[-1]

    def next_batch(self, block: bool) -> list[tuple[Future, Any]]:
        assert not block
        batch, self.ended = self.ended, []
        return batch

    def end(self, future: Future, result: Any = None) -> None:
        self.ended.append((future, line_of(trial(future.seed)) if result is None else result))


def trial(seed: int) -> Trial:
    return Trial(seed, 0, {"outcome": "Success", "reason": "", "metrics": {}})


@pytest.fixture
def scheduler() -> Scheduler:
    return Scheduler({"one": 2, "two": 1})


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch, scheduler: Scheduler, clock: Clock) -> Cluster:
    """Its naps are periods of a clock, and nothing else takes time."""

    @contextmanager
    def client() -> Iterator[Scheduler]:
        yield scheduler

    def nap(seconds: float) -> None:
        clock.now += seconds
        if clock.now > 1000.0:
            raise AssertionError("nothing ends any more")
        Naps.then(clock.now)

    clock.now = 100.0
    made = Cluster(line_of, "tcp://played")  # type: ignore[arg-type]
    monkeypatch.setattr(made, "_client", client)
    monkeypatch.setattr(distributed, "as_completed", lambda **_: scheduler)
    monkeypatch.setattr("time.monotonic", clock)
    monkeypatch.setattr("time.sleep", nap)
    monkeypatch.setattr(module, "NAPS_S", 0.5)
    return made


class Naps:
    """What happens while it waits."""

    @staticmethod
    def then(now: float) -> None:
        raise AssertionError("nobody said what happens")


def on_nap(monkeypatch: pytest.MonkeyPatch, what: Any) -> None:
    monkeypatch.setattr(Naps, "then", staticmethod(what))


def test_each_thread_has_two_trials_and_each_seed_comes_once(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    most = list[int]()

    def end_first(_: float) -> None:
        open_ones = [item for item in scheduler.given if item.seed not in done]
        most.append(len(open_ones))
        done.add(open_ones[0].seed)
        scheduler.end(open_ones[0])

    done = set[int]()
    on_nap(monkeypatch, end_first)
    batches = list(cluster.trials(range(20)))
    assert [item.seed for batch in batches for item in batch] == list(range(20))
    assert max(most) == 6
    assert most[:15] == [6] * 15
    assert [item.seed for item in scheduler.given] == list(range(20))
    assert scheduler.cancelled == []


def test_no_seed_at_all_ends_at_once(cluster: Cluster, scheduler: Scheduler) -> None:
    assert list(cluster.trials(())) == []
    assert scheduler.given == []


def test_a_late_trial_is_given_to_an_idle_worker_and_counts_once(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    scheduler.idle = ["two"]
    times = list[float]()

    def end_the_copy(now: float) -> None:
        if len(scheduler.given) == 2:
            times.append(now)
            scheduler.end(scheduler.given[1])
            scheduler.end(scheduler.given[0])

    on_nap(monkeypatch, end_the_copy)
    (done,) = list(cluster.trials([7]))
    assert [item.seed for item in done] == [7]
    assert [item.worker for item in scheduler.given] == [None, "two"]
    assert 105.0 < times[0] <= 108.0  # five seconds, and a look each two
    assert scheduler.cancelled == [scheduler.given[0]]


def test_at_most_four_workers_have_one_trial(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    scheduler.idle = ["one", "two"]

    def end_at_last(now: float) -> None:
        if now > 200.0:
            scheduler.end(scheduler.given[0])

    on_nap(monkeypatch, end_at_last)
    assert [len(batch) for batch in cluster.trials([1])] == [1]
    assert len(scheduler.given) == module.MAX_WORKERS_PER_TRIAL == 4
    assert scheduler.cancelled == scheduler.given[1:]


def test_a_busy_worker_is_given_no_copy(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    on_nap(monkeypatch, lambda now: scheduler.end(scheduler.given[0]) if now > 150.0 else None)
    assert [len(batch) for batch in cluster.trials([1])] == [1]
    assert len(scheduler.given) == 1


def test_who_leaves_early_cancels_what_is_on_its_way(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    on_nap(monkeypatch, lambda _: scheduler.end(scheduler.given[0]))
    trials = cluster.trials(range(50))
    assert [item.seed for item in next(trials)] == [0]
    trials.close()
    assert [item.seed for item in scheduler.cancelled] == [1, 2, 3, 4, 5]


def test_a_trial_that_comes_back_as_another_is_a_fault(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    on_nap(monkeypatch, lambda _: scheduler.end(scheduler.given[0], line_of(trial(99))))
    with pytest.raises(TrialFault, match="seed 3 came back with invalid content"):
        list(cluster.trials([3]))


def test_dead_worker_ends_its_trial_and_a_missing_answer_does_not(
    cluster: Cluster, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dies(_: float) -> None:
        future = scheduler.given[-1]
        future.status = "error"
        scheduler.end(future, (None, distributed.KilledWorker(future.key, WORKER, 3), None))

    on_nap(monkeypatch, dies)
    ((died,),) = list(cluster.trials([3]))
    assert (died.seed, died.status) == (3, 5)
    assert died.summary["reason"] == "its worker died 4 times"

    def is_lost(_: float) -> None:
        scheduler.given[-1].status = "lost"
        scheduler.end(scheduler.given[-1])

    on_nap(monkeypatch, is_lost)
    again = Cluster(line_of, "tcp://played")  # type: ignore[arg-type]
    monkeypatch.setattr(again, "_client", cluster._client)
    with pytest.raises(ClusterLost, match="tcp://played is gone"):
        list(again.trials([3]))
