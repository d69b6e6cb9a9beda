"""Work of each process of a campaign, and its results, with stub processes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.evaluation.campaigns import workers as module
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.workers import TrialFault, Workers
from tests.conftest import Clock


class Played:
    """A process that says what `answer` gives when it is asked; None: it has died."""

    made: list[Played]
    answer: Callable[[Played], list[Trial] | None]

    def __init__(self, work: object) -> None:
        self.seeds, self.given, self.begun = deque[int](), list[list[int]](), False
        self.connection = self
        self.process = SimpleNamespace(
            join=lambda *_: None, exitcode=-9, is_alive=lambda: False, terminate=lambda: None
        )
        self.is_closed = False
        self.made.append(self)

    def give(self, seeds: list[int]) -> None:
        self.seeds.extend(seeds)
        self.given.append(seeds)

    def taken(self) -> list[Trial] | None:
        return type(self).answer(self)

    def end_trials(self, count: int) -> list[Trial]:
        self.begun = True
        return [trial(self.seeds.popleft()) for _ in range(count)]

    def close(self) -> None:
        self.is_closed = True


def trial(seed: int) -> Trial:
    return Trial(seed, 0, {"outcome": "Success", "reason": "", "metrics": {}})


def work(seed: int) -> Trial:
    raise AssertionError("it is played")


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> type[Played]:
    def first(connections: list[Any], timeout: float | None = None) -> list[Any]:
        clock.now += 0.011
        return connections[:1]

    made = type("Hand", (Played,), {"made": []})
    for name, value in {"Worker": made, "Connection": made, "wait_for": first}.items():
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr("time.monotonic", clock)
    clock.now = 100.0
    return made


def seeds_of(batches: Iterable[list[Trial]]) -> list[int]:
    return [item.seed for batch in batches for item in batch]


def test_a_process_has_a_tenth_of_a_second_of_work_before_it(played: type[Played]) -> None:
    played.answer = lambda process: process.end_trials(1)
    assert seeds_of(Workers(work, 1).trials(range(40))) == list(range(40))
    (process,) = played.made
    # The first two show how long one takes, 0.011 s: nine of them are 0.1 s, beside the one that runs.
    assert process.given[:4] == [[0], [1], list(range(2, 12)), [12]]
    assert process.is_closed


def test_long_trials_are_given_one_by_one_and_none_too_many(played: type[Played], clock: Clock) -> None:
    def answer(process: Played) -> list[Trial]:
        clock.now += 1.0
        return process.end_trials(1)

    played.answer = answer
    assert sorted(seeds_of(Workers(work, 3).trials(range(8)))) == list(range(8))
    assert len(played.made) == 3
    assert all(len(seeds) == 1 for process in played.made for seeds in process.given)
    assert len(Workers(work, 9)._workers) == 0
    played.made.clear()
    assert sorted(seeds_of(Workers(work, 9).trials(range(2)))) == [0, 1]
    assert len(played.made) == 2


def test_very_short_trials_are_given_256_at_a_time(played: type[Played], clock: Clock) -> None:
    def answer(process: Played) -> list[Trial]:
        clock.now -= 0.011 - 1e-6
        return process.end_trials(1)

    played.answer = answer
    seeds_of(Workers(work, 1).trials(range(1000)))
    assert max(len(seeds) for seeds in played.made[0].given) == 1 + module.MOST_AHEAD == 257


def test_what_a_dead_process_had_is_done_by_another_in_order(played: type[Played]) -> None:
    def answer(process: Played) -> list[Trial] | None:
        if process is played.made[0] and process.seeds[0] == 3:
            return None
        return process.end_trials(1)

    played.answer = answer
    assert seeds_of(Workers(work, 1).trials(range(20))) == list(range(20))
    assert len(played.made) == 2
    assert played.made[1].given[0] == [3]


def test_the_fifth_death_in_one_trial_is_its_end(played: type[Played]) -> None:
    def answer(process: Played) -> list[Trial] | None:
        if process.seeds[0] != 2:
            return process.end_trials(1)
        process.begun = True
        return None

    played.answer = answer
    done = [item for batch in Workers(work, 1).trials(range(4)) for item in batch]
    assert [(item.seed, item.status) for item in done] == [(0, 0), (1, 0), (2, 5), (3, 0)]
    assert done[2].summary["reason"] == "its process died 5 times, at last by signal 9"
    assert len(played.made) == 6


def test_processes_that_never_begin_end_the_campaign(played: type[Played]) -> None:
    played.answer = lambda process: None
    with pytest.raises(TrialFault, match="die before they begin, at last by signal 9"):
        seeds_of(Workers(work, 1).trials(range(4)))
    assert len(played.made) == module.MAX_FAILED_STARTS + 1 == 21
