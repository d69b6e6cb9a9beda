"""Stop of a run when it reaches a level."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from handcart.files.errors import InputError
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared
from handcart.primitives.outcomes.outcome import Fail

from .rare_event import Importance


class NotSplit(InputError):
    """Error for a backend whose runs cannot be continued several times from one saved state."""

    def __init__(self, backend: str) -> None:
        super().__init__(f"--rare on the backend {backend!r}; allowed: a simulated one that can be put back")


class LevelStop(RunObserver):
    """Observer that stops a run after an action as soon as the run's importance has reached a level.

    The importance, as in multilevel splitting, shows how near a run is to a rare outcome; it is computed from
    the number of attempts that the run has used up.
    """

    def __init__(
        self, importance: Importance, level: int, heard: Interrupts, used: Mapping[int, int]
    ) -> None:
        """Prepare for a run that has not started.

        Args:
            importance: kind of importance.
            level: importance at which the run is stopped.
            heard: interrupts by which the run is stopped.
            used: attempts that were used up before, by index of the action.
        """
        self._importance, self._level, self._heard = importance, level, heard
        self.used = Counter(used)
        """Attempts that are used up so far, by index of the action."""
        self.steps = 0
        """Number of actions that have ended in this run."""

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Raise `NotSplit` if runs cannot be split, because the backend's state cannot be saved and
        restored.
        """
        backend = prepared.backend
        if not backend.simulated or backend.state() is None:
            raise NotSplit(prepared.backend_name)

    def event(self, event: Event) -> None:
        """Count an action that has ended, and stop the run if the run's importance (nearness to the rare
        outcome) has reached the level.
        """
        if not isinstance(event, Ended):
            return
        self.steps += 1
        if isinstance(event.outcome, Fail):
            action = event.action
            left = action.allowance.most - self.used[action.index]
            self.used[action.index] += left if self._for_good(event.outcome) else 1
            if self.near:
                self._heard.stop()

    def _for_good(self, outcome: Fail) -> bool:
        return outcome.permanent and self._importance == "attempts"

    @property
    def near(self) -> bool:
        """True if the run's importance (its nearness to the rare outcome) has reached the level."""
        return importance_of(self.used, self._importance) >= self._level


def importance_of(used: Mapping[int, int], importance: Importance) -> int:
    """Return the importance of a run, a measure of how near it is to a rare outcome.

    It is a number of used attempts: for `fails` the total over all actions, otherwise that of the action with
    the most.

    Args:
        used: number of used attempts, by index of the action.
        importance: kind of importance.
    """
    counts = used.values()
    return sum(counts) if importance == "fails" else max(counts, default=0)
