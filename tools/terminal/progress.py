"""Telling a person how a run gets on."""

from __future__ import annotations

import select
import sys
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.markup import escape

from handcart.backends.robot.robot import Robot
from handcart.files.printable import printable
from handcart.networks.coordination.events import Ended, Event, LeftOut, Planned, Restoring, RunEnded, Started
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import NoWay
from handcart.networks.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.outcome import Fail, GiveUp, Success

COLOURS = {"Success": "green", "Fail": "yellow", "GiveUp": "red"}


class Progress(RunObserver):
    """One line for each thing that ends, and on a terminal what goes on just now.

    Writes to stderr, so that stdout holds the result alone.
    """

    def __init__(self) -> None:
        self._console = Console(stderr=True, highlight=False, soft_wrap=True)
        self._status = self._console.status("planning")
        self._now, self._next = "planning", 0.0

    def __enter__(self) -> Progress:
        if self._console.is_terminal:
            self._status.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def end(self) -> None:
        """Nothing goes on any more; a second call does nothing."""
        with suppress(OSError):
            self._status.stop()

    def event(self, event: Event) -> None:
        """Tell of an event."""
        match event:
            case Planned(time, situation, NoWay()):
                self._line(time, f"no way leads on from {situation}")
            case Started(_, number, action, _, fails):
                again = f", failed {fails} times before" if fails else ""
                self._now = escape(f"{number}. {action.do}: {action.source} to {action.target}{again}")
                self._status.update(self._now)
            case Restoring(time, action, reason):
                self._line(time, f"{action.do} restores: {reason}", "yellow")
            case Ended(time, number, action, _, outcome):
                self._ended(time, number, f"{action.do}: {action.source} to {action.target}", outcome)
            case LeftOut(time, action, reason):
                self._line(time, f"{action.do} is not started: {reason}", "yellow")
            case Planned() | RunEnded():
                pass

    def period(self, robot: Robot) -> None:
        """Tell how late it is, on a terminal."""
        if robot.time >= self._next:
            self._next = robot.time + 0.5
            self._status.update(f"[dim]{robot.time:8.1f} s[/dim]  {self._now}")

    def say(self, words: str) -> None:
        """Tell something that should be known before anything moves."""
        self._print(escape(printable(words)))

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Tell what the user should know before the run starts."""
        for words in prepared.warnings:
            self._print(f"[yellow]warning: {escape(words)}[/yellow]")
        far = prepared.robot.stopping_distance
        words = f"{run_dir}: Ctrl-C or `handcart stop` with that folder stops the base within {far:.2f} m"
        self._print(f"[dim]{escape(words)}[/dim]")

    def ask(self, action: Action) -> None:
        """Ask the operator for permission."""
        how = "y or n and Enter, or " if sys.stdin.isatty() else ""
        self._status.stop()
        self._print(f"[bold]may {escape(str(action))} start? {how}handcart permit|refuse[/bold]")

    def typed(self) -> bool | None:
        """What somebody typed: y or n and Enter; None for nothing yet, or anything else."""
        if not sys.stdin.isatty() or not select.select([sys.stdin], [], [], 0.0)[0]:
            return None
        return {"y": True, "yes": True, "n": False, "no": False}.get(sys.stdin.readline().strip().lower())

    def _ended(self, time: float, number: int, what: str, outcome: Success | Fail | GiveUp) -> None:
        word = type(outcome).__name__
        reason = "" if isinstance(outcome, Success) else f": {outcome.reason}"
        self._line(time, f"{number}. {what}: {word}{reason}", COLOURS[word])

    def _line(self, time: float, words: str, colour: str = "default") -> None:
        self._print(f"[dim]{time:8.1f} s[/dim]  [{colour}]{escape(words)}[/{colour}]")

    def _print(self, words: str) -> None:
        with suppress(OSError):  # nobody reads it any more: that must not end a run (row K14)
            self._console.print(words)
