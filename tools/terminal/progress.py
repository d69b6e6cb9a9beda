"""Progress output of a run for a person."""

from __future__ import annotations

import select
import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.markup import escape

from handcart.backends.robot.robot import Robot
from handcart.files.printable import printable
from handcart.networks.events.events import (
    AimChanged,
    Ended,
    Event,
    LeftOut,
    Planned,
    Restoring,
    RunEnded,
    Started,
)
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.graph.network import Action
from handcart.networks.graph.planner import NoWay, Plan
from handcart.networks.task.preparing import Prepared
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.numerics.compiled import hearing_of_compiling
from handcart.tools.terminal.first_use import COMPILING_MESSAGE as COMPILING_MESSAGE

LOADING_MESSAGE = "loading"
COLOUR_BY_OUTCOME = {"Success": "green", "Fail": "yellow", "GiveUp": "red"}


class Progress(RunObserver):
    """Progress output: one line for each event, and on a terminal the present activity.

    Writes to stderr, so that stdout holds the result alone.
    """

    def __init__(self, begins: Callable[[], None] = lambda: None) -> None:
        """Prepare the output; `begins` is called before anything is printed."""
        self._begins = begins
        self._console = Console(stderr=True, highlight=False, soft_wrap=True)
        self._status = self._console.status(LOADING_MESSAGE)
        self._now, self._next = LOADING_MESSAGE, 0.0
        self._begun, self._cost, self._rest = 0.0, 0.0, 0.0
        """Start of the action, its expected duration, and that of all actions after it, in [s]."""
        self._way: tuple[Action, ...] = ()
        """Actions of the last plan."""
        self._run_dir = Path()
        self._compiled = False
        self._listening = ExitStack()

    def __enter__(self) -> Progress:
        if self._console.is_terminal:
            self._begins()
            self._status.start()
        self._listening.enter_context(hearing_of_compiling(self._compiling))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._listening.close()
        self.end()

    def end(self) -> None:
        """Remove the line with the robot's present action from the terminal; a second call does nothing."""
        with suppress(OSError):
            self._status.stop()

    def event(self, event: Event) -> None:
        """Print an event of the run."""
        match event:
            case Planned(time, situation, NoWay()):
                self._line(time, f"no way leads on from {situation}")
            case Planned(plan=Plan(actions=actions)):
                self._way = actions
            case Started(time, number, action, _, fails):
                again = f", failed {fails} times before" if fails else ""
                self._begun, self._cost = time, action.cost_s
                after = self._way[self._way.index(action) + 1 :] if action in self._way else ()
                self._rest = sum(item.cost_s for item in after)
                self._tell(f"{number}. {action.name}: {action.source} to {action.target}{again}")
            case Restoring(time, action, reason):
                self._begun, self._cost = time, 0.0
                self._tell(f"{action.do} restores")
                self._line(time, f"{action.do} restores: {reason}", "yellow")
            case Ended(time, number, action, _, outcome):
                self._ended(time, number, f"{action.name}: {action.source} to {action.target}", outcome)
            case LeftOut(time, action, reason):
                self._line(time, f"{action.name} is not started: {reason}", "yellow")
            case AimChanged(time, words):
                self._line(time, words, "yellow")
            case RunEnded():
                self._tell("writing down what was seen")

    def period(self, robot: Robot) -> None:
        """Update the line on the terminal with the run's elapsed time and present action."""
        if robot.time >= self._next:
            self._next = robot.time + 0.5
            self._status.update(f"[dim]{robot.time:8.1f} s[/dim]  {self._now}{self._how_far(robot.time)}")

    def say(self, words: str) -> None:
        """Print a message that the user should read before the robot moves."""
        self._print(escape(printable(words)))

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Print the warnings for the user, the run's folder and how to stop, before the run starts.

        Args:
            prepared: the checked task with its robot.
            run_dir: folder of the run.
        """
        self._run_dir = run_dir
        self._tell("planning")
        for words in prepared.warnings:
            self._print(f"[yellow]warning: {escape(words)}[/yellow]")
        far = prepared.robot.stopping_distance
        words = f"{run_dir}: Ctrl-C or `handcart stop` with that folder stops the base within {far:.2f} m"
        self._print(f"[dim]{escape(words)}[/dim]")

    def ask(self, action: Action) -> None:
        """Print the question whether an action may start, and the commands with which to answer; do not wait
        for the answer.
        """
        here = " y or n and Enter, or:" if sys.stdin.isatty() else ""
        self._status.stop()
        run = shlex.quote(str(self._run_dir))
        self._print(f"[bold]may {escape(str(action))} start?[/bold]{here}")
        self._print(escape(f"  handcart permit {run}\n  handcart refuse {run}"))

    def offer(self, commands: Sequence[str]) -> None:
        """Print shell commands that the user can run next, in a form that can be pasted."""
        for command in commands:
            self._print(f"[dim]  {escape(printable(command))}[/dim]")

    def typed(self) -> bool | None:
        """Return the answer that was typed with Enter, without waiting for it.

        The answer is True for y or yes, False for n or no. It is None for another input, or without input.
        """
        if not sys.stdin.isatty() or not select.select([sys.stdin], [], [], 0.0)[0]:
            return None
        return {"y": True, "yes": True, "n": False, "no": False}.get(sys.stdin.readline().strip().lower())

    def _tell(self, words: str) -> None:
        """Show the present activity."""
        self._now = escape(words)
        self._status.update(self._now)

    def _how_far(self, time: float) -> str:
        """Return the action's elapsed and expected time, and the expected time of the rest to the goal, as
        text.
        """
        if not self._cost:
            return ""
        after = f", {self._rest:.0f} s more to the goal" if self._rest else ""
        return f"[dim]  {time - self._begun:.0f} of about {self._cost:.0f} s{after}[/dim]"

    def _compiling(self, begins: bool) -> None:
        self._status.update(COMPILING_MESSAGE if begins else self._now)
        if begins and not self._compiled and not self._console.is_terminal:
            self._print(COMPILING_MESSAGE)
        self._compiled = True

    def _ended(self, time: float, number: int, what: str, outcome: Success | Fail | GiveUp) -> None:
        word = type(outcome).__name__
        reason = "" if isinstance(outcome, Success) else f": {outcome.reason}"
        self._line(time, f"{number}. {what}: {word}{reason}", COLOUR_BY_OUTCOME[word])

    def _line(self, time: float, words: str, colour: str = "default") -> None:
        self._print(f"[dim]{time:8.1f} s[/dim]  [{colour}]{escape(words)}[/{colour}]")

    def _print(self, words: str) -> None:
        self._begins()
        with suppress(OSError):  # the reader is gone: that must not end a run (row K14)
            self._console.print(words)
