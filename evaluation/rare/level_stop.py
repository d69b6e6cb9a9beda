"""Stopping a run where it comes to a level."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from handcart.files.errors import InputError
from handcart.networks.coordination.events import Ended, Event
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.outcome import Fail

from .rare_event import Importance


class NotSplit(InputError):
    """A run can't be taken on again and again from where it stands."""

    def __init__(self, backend: str) -> None:
        super().__init__(f"--rare on the backend {backend!r}; allowed: a simulated one that can be put back")


class LevelStop(RunObserver):
    """Counts how near a run comes, and stops it between two actions as soon as it is near enough."""

    def __init__(
        self, importance: Importance, level: int, heard: Interrupts, used: Mapping[int, int]
    ) -> None:
        """Nothing has been run.

        Args:
            importance: what is counted.
            level: where it is stopped.
            heard: by whom it is stopped.
            used: attempts that were used up before, by the actions' numbers.
        """
        self._importance, self._level, self._heard = importance, level, heard
        self.used = Counter(used)
        """Attempts that are used up by now, by the actions' numbers."""
        self.steps = 0
        """Actions that it has started."""

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Refuse what can't be put back to where it was."""
        backend = prepared.backend
        if not backend.simulated or backend.state() is None:
            raise NotSplit(prepared.backend_name)

    def event(self, event: Event) -> None:
        """Count an action that has ended."""
        if not isinstance(event, Ended):
            return
        self.steps += 1
        if isinstance(event.outcome, Fail):
            action = event.action
            left = action.attempts - self.used[action.index]
            self.used[action.index] += left if self._for_good(event.outcome) else 1
            if self.near:
                self._heard.stop()

    def _for_good(self, outcome: Fail) -> bool:
        return outcome.permanent and self._importance == "attempts"

    @property
    def near(self) -> bool:
        """Whether it has come to the level."""
        return importance_of(self.used, self._importance) >= self._level


def importance_of(used: Mapping[int, int], importance: Importance) -> int:
    """How near a run has come, by what it has used up."""
    counts = used.values()
    return sum(counts) if importance == "fails" else max(counts, default=0)
