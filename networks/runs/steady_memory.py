"""Garbage collection at times when it delays nothing."""

from __future__ import annotations

import gc
from pathlib import Path
from typing import TYPE_CHECKING

from typing_extensions import override

from handcart.networks.events.events import Ended, Event
from handcart.networks.events.run_observer import RunObserver

if TYPE_CHECKING:
    from handcart.networks.task.preparing import Prepared


class SteadyMemory(RunObserver):
    """Observer that restricts garbage collection to the time between actions.

    A collection among a million objects stops the control loop for 20 ms. Objects that exist at the start
    are excluded from all collections.
    """

    @override
    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self._was_on = gc.isenabled()
        gc.collect()
        gc.freeze()
        gc.disable()

    def event(self, event: Event) -> None:
        """Collect garbage after an action has ended."""
        if isinstance(event, Ended):
            gc.collect()

    @override
    def end(self) -> None:
        gc.unfreeze()
        if self._was_on:
            gc.enable()
