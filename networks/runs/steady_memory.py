"""Garbage collection at times when it delays nothing."""

from __future__ import annotations

import atexit
import gc
from pathlib import Path
from typing import TYPE_CHECKING

from typing_extensions import override

from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared


class SteadyMemory(RunObserver):
    """Observer of a run that restricts Python's garbage collection to the time between actions.

    With a million objects, a collection would stop the control loop for 20 ms. Objects that exist when a
    process begins its first run, mostly code, are excluded from all later collections.
    """

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self._was_on = gc.isenabled()
        gc.collect()
        if gc.get_freeze_count() == 0:
            gc.freeze()
            atexit.register(gc.unfreeze)  # libraries report what outlives the interpreter as leaked
        gc.disable()

    def event(self, event: Event) -> None:
        """Run Python's garbage collection if the event is the end of an action."""
        if isinstance(event, Ended):
            gc.collect()

    @override
    def end(self) -> None:
        if self._was_on:
            gc.enable()
