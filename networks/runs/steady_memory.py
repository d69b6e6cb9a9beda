"""Collecting garbage where it delays nothing."""

from __future__ import annotations

import gc
from types import TracebackType

from handcart.backends.robot import Robot

from handcart.networks.coordination.events import Ended, Event


class SteadyMemory:
    """An observer of a run, and a context manager within which nothing is collected but between actions.

    A collection among a million objects stops the control loop for 20 ms. What is there at the start stays
    out of all of them.
    """

    def __enter__(self) -> SteadyMemory:
        self._was_on = gc.isenabled()
        gc.collect()
        gc.freeze()
        gc.disable()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        gc.unfreeze()
        if self._was_on:
            gc.enable()

    def look(self, _robot: Robot) -> None:
        """A period has passed: nothing is done."""

    def __call__(self, event: Event) -> None:
        """An action has ended: collect, before the next."""
        if isinstance(event, Ended):
            gc.collect()
