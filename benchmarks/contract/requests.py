"""Test that pause, stop, cancel and restore are applied once, to the action that they name.

    python -m benchmarks.contract.requests [--tasks WORD] [--seed 0] [--first 5] [--last 10] [--every 1]

Shipped tasks are run once to measure the length of each action, and once more with a copy of the process
for each request: in each of the first and last periods of every action, between actions, and at each
event. A copy sends one request and runs on until its effect is known. Counted are requests that were eaten
(taken, without an effect), doubled, or misapplied (to another action). Prints a line for each task, and
the sum; status 1 if there is one. After Ctrl-C it reports on the requests until then.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.cut_off import CutOff
from handcart.evaluation.conformance.faults.forked import forkable
from handcart.evaluation.conformance.faults.repertoire import declared
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.run_life import RunState
from handcart.networks.coordination.supervision import Request
from handcart.networks.events.events import Ended, Event, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.task.preparing import prepare
from handcart.primitives.outcomes.outcome import Success

REQUEST_KINDS = (Request.PAUSE, Request.STOP, Request.CANCEL, Request.RESTORE)
WRONG_WORDS = ("eaten", "doubled", "misapplied", "died")
ANSWER_PERIODS = 400
"""Periods after a request in which something has to come of a stop or a pause."""
PAUSE_PERIODS = 3
"""Periods that a pause is held."""
TRIAL_CPU_S = 120
SHOWN_EVERY = 20
"""Requests between two lines of progress."""


@dataclass
class Asked:
    """One request in a copy of the process, and what has come of it so far."""

    what: Request
    run: Coordinator
    pipe: int
    meant: int | None = None
    refused: str = ""
    events: list[Event] = field(default_factory=list)
    periods: int = 0
    paused: int = 0
    at_s: float = 0.0
    resumed: int | None = None

    def ask(self) -> None:
        """Ask now; first for the action before, which must be refused."""
        self.meant = self.run.acting
        before = 0 if self.meant is None else self.meant - 1
        if self.what is not Request.STOP and before and not self.run.ask(self.what, before):
            self.tell("misapplied: taken for an ended action")
        over = self.run.life.state is RunState.ENDED
        self.refused = self.run.ask(self.what)
        if over:
            self.tell("" if self.refused or self.what is Request.STOP else "eaten: taken after the end")

    def tell(self, verdict: str) -> None:
        """Report, and end this copy."""
        os.write(self.pipe, json.dumps(verdict).encode())
        os._exit(0)

    @property
    def started(self) -> int:
        """Number of actions started since the request."""
        return sum(isinstance(event, Started) for event in self.events)

    def outcome(self) -> Any:
        """Outcome of the action that was named; None while it runs."""
        return next(
            (
                event.outcome
                for event in self.events
                if isinstance(event, Ended) and event.number == self.meant
            ),
            None,
        )

    def others_failed(self) -> bool:
        """Return whether another action did not succeed."""
        ended = [event for event in self.events if isinstance(event, Ended) and event.number != self.meant]
        return any(not isinstance(event.outcome, Success) for event in ended)

    def look(self, robot: Any, end: RunEnd | None) -> None:
        """Update after a period, or after the end of the run."""
        self.periods += 1
        {
            Request.STOP: self._stop,
            Request.CANCEL: self._cancel,
            Request.RESTORE: self._restore,
            Request.PAUSE: self._pause,
        }[self.what](robot, end)

    def _stop(self, _robot: Any, end: RunEnd | None) -> None:
        if end is not None:
            right = end.outcome == "Cancelled" and "stopped by request" in end.reason
            self.tell("" if right else f"eaten: the run ended with {end.outcome} {end.reason}")
        if self.started > (self.meant is None):
            self.tell("eaten: another action began after a stop")
        if self.periods > ANSWER_PERIODS:
            self.tell("eaten: it does not stop")

    def _cancel(self, _robot: Any, end: RunEnd | None) -> None:
        if self.others_failed():
            self.tell("misapplied: another action failed by a cancel")
        if end is None:
            return
        over = end.outcome in ("Success", "Fail") and self.refused
        right = end.outcome in ("Cancelled", "GiveUp") or over
        if not right:
            self.tell(f"eaten: the run ended with {end.outcome}")
        if self.meant is not None and isinstance(self.outcome(), Success):
            self.tell("eaten: the action that was cancelled succeeded")
        self.tell(f"give up: {end.reason}" if end.outcome == "GiveUp" else "")

    def _restore(self, _robot: Any, end: RunEnd | None) -> None:
        if self.meant is None:
            if not self.refused:
                self.tell("misapplied: a restore was taken while no action ran")
            if self.others_failed():
                self.tell("misapplied: the next action failed by a restore")
            if end is not None or self.periods > 12:
                self.tell("")
            return
        found = self.outcome()
        if found is not None or end is not None:
            word = type(found).__name__
            gave_up = f"give up: {found or end}"
            self.tell({"Fail": "", "GiveUp": gave_up}.get(word, f"eaten: the action ended with {word}"))
        if self.others_failed():
            self.tell("misapplied: another action failed by a restore")

    def _pause(self, robot: Any, end: RunEnd | None) -> None:
        paused, acting = self.run.life.paused, self.run.acting
        if end is not None:
            owed = self.resumed is None and (self.started > 0 or self.paused > 0)
            self.tell(f"eaten: {end.outcome} {end.reason}" if owed else "")
        if self.resumed is not None:
            if paused:
                self.tell("doubled: it pauses again")
            if self.periods > self.resumed + 5:
                self.tell("")
        elif paused:
            if self.meant not in (None, acting):
                self.tell(f"misapplied: action {acting} is paused, not {self.meant}")
            self.at_s = robot.time if not self.paused else self.at_s
            self.paused += 1
            if robot.time != self.at_s:
                self.tell("eaten: its time continues while it is paused")
            if self.paused == PAUSE_PERIODS:
                self.resumed = self.periods + 1
                if wrong := self.run.ask(Request.RESUME):
                    self.tell(f"eaten: it is not continued: {wrong}")
        elif self.started > 1 or self.periods > ANSWER_PERIODS:
            self.tell("eaten: it does not pause")


class Campaign:
    """One run of a task, in copies of which requests are made."""

    def __init__(self, task: Path, settings: dict[str, str], seed: int) -> None:
        self.task, self.settings, self.seed = task, settings, seed
        self.found: Counter[str] = Counter()
        self.wrong: list[str] = []
        self._asked: Asked | None = None
        self._run: Coordinator | None = None
        self._at_events = False

    def spans(self) -> dict[int, tuple[int, int]]:
        """Run once without requests; give the first and last period of each action, by its number."""
        spans: dict[int, tuple[int, int]] = {}

        def look(period: int) -> None:
            assert self._run is not None
            if (number := self._run.acting) is not None:
                spans[number] = (spans.get(number, (period, period))[0], period)

        self._drive(look)
        return spans

    def ask_in(self, periods: set[int]) -> None:
        """Run once more, with a copy for each request in those periods and at each event."""
        self._at_events = True
        self._drive(lambda period: self._branch(f"period {period}") if period in periods else None)

    def _drive(self, before: Callable[[int], None]) -> None:
        with prepare(self.task, "kinematic", self.settings, self.seed) as prepared:
            self._run = run = Coordinator(
                prepared.task.network, prepared.robot, prepared.model, observers=[self._hear]
            )
            periods, period, end = run.run(), 0, None
            while end is None:
                before(period)
                period += 1
                try:
                    next(periods)
                except StopIteration as ended:
                    end = ended.value
                if self._asked is not None:
                    self._asked.look(prepared.robot, end)
                if end is None:
                    prepared.robot.step(run.life.paused)

    def _hear(self, event: Event) -> None:
        if self._asked is not None:
            self._asked.events.append(event)
        elif self._at_events:
            self._branch(type(event).__name__)

    def _branch(self, where: str) -> None:
        """Make a request of each kind in a copy of this process."""
        if self._asked is not None:
            return
        assert self._run is not None
        for what in REQUEST_KINDS:
            read, write = os.pipe()
            child = os.fork()
            if child == 0:
                os.close(read)
                signal.signal(signal.SIGINT, signal.SIG_DFL)  # the first process reports
                resource.setrlimit(resource.RLIMIT_CPU, (TRIAL_CPU_S, TRIAL_CPU_S))
                self._asked = Asked(what, self._run, write)
                self._asked.ask()
                return
            os.close(write)
            with os.fdopen(read, "rb") as stream:
                answer = stream.read()
            os.waitpid(child, 0)
            verdict = json.loads(answer) if answer else "died"
            self.found[verdict.split(":")[0] or "right"] += 1
            if self.found.total() % SHOWN_EVERY == 1:
                print(f"  {self.found.total()} requests, at {where}", file=sys.stderr, flush=True)
            if not verdict:
                continue
            words = f"{what.value} at {where}, action {self._run.acting}: {verdict}"
            if verdict.startswith("give up"):
                print(f"    {words}", flush=True)
            else:
                self.wrong.append(words)
                print(f"    WRONG {words}", flush=True)


def main() -> int:
    """Print what came of it."""
    words = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    words.add_argument("--tasks", default="", help="only those with this in their path")
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--first", type=int, default=5, help="periods of each action from its start")
    words.add_argument("--last", type=int, default=10, help="periods of each action before its end")
    words.add_argument("--every", type=int, default=1, help="only every so many of these periods")
    wanted = words.parse_args()
    began, campaigns = time.monotonic(), list[Campaign]()
    with CutOff() as cut:
        for task, settings in declared().items():
            if wanted.tasks in str(task):
                campaigns.append(Campaign(task, dict(settings), wanted.seed))
                ask_all(campaigns[-1], wanted)
    found = sum((campaign.found for campaign in campaigns), Counter[str]())
    print(f"{sum_line(found)}; {time.monotonic() - began:.0f} s")
    return cut.status(not found or any(found[word] for word in WRONG_WORDS))


def ask_all(campaign: Campaign, wanted: argparse.Namespace) -> None:
    """Make the requests of a task and print its line."""
    print(f"{campaign.task.parent.name}/{campaign.task.name}: run without requests ...", flush=True)
    with forkable():
        spans = campaign.spans()
        periods = {
            period
            for first, last in spans.values()
            for period in [
                *range(first - 1, first + wanted.first),
                *range(last - wanted.last + 1, last + 3),
            ]
            if period % wanted.every == 0
        }
        try:
            campaign.ask_in(periods)
        finally:
            count = campaign.found.total()
            print(f"  {len(spans)} actions, {count} requests: {dict(campaign.found)}", flush=True)


def sum_line(found: Counter[str]) -> str:
    """Return the sum over all tasks: requests, those applied wrongly by kind, those that gave up."""
    counts = {word: found[word] for word in WRONG_WORDS}
    return f"{found.total()} requests, {counts}; gave up {found['give up']}"


if __name__ == "__main__":
    raise SystemExit(main())
