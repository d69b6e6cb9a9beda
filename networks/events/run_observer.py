"""Interface for observing a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.backends.robot.robot import Robot

from .events import Event
from .run_end import RunEnd

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared


class RunObserver:
    """Observer of a run, which does not influence the run; a subclass overrides the events that it needs."""

    def say(self, words: str) -> None:
        """Handle a message that a person should read before anything moves."""

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Handle the begin, or the resume, of a run in a folder."""

    def period(self, robot: Robot) -> None:
        """Handle the end of a control period during the run."""

    def event(self, event: Event) -> None:
        """Handle an event of the run, such as the start of an action; the journal contains its fields."""

    def end(self) -> None:
        """Finish observing after the run has ended or could not continue; called once."""

    def figures(self, end: RunEnd) -> Mapping[str, Any]:
        """Return figures of a run that has ended, to be added to the `metrics` of its result.

        The values can be written as JSON.

        Args:
            end: end of the run.
        """
        return {}
