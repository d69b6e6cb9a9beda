"""Drivers at the other end of topics within this process."""

from __future__ import annotations

from typing import Any, Protocol

from handcart.backends.backend import Backend

from .ros_link import Link


class OtherEnd(Protocol):
    """Drivers within this process: their time passes with the steps of the program, and no clock is read."""

    @property
    def link(self) -> Link:
        """Return the program's end of the topics."""

    @property
    def inner(self) -> Backend | None:
        """Return the simulated robot; None without one."""

    def wait(self, seconds: float) -> None:
        """Let a time in [s] pass before the first step."""

    def step(self) -> None:
        """Let a period pass."""

    def state(self) -> dict[str, object] | None:
        """Return the state of robot and drivers; None if they keep none."""

    def set_state(self, state: Any) -> None:
        """Restore what `state` returned."""

    def close(self) -> None:
        """Release all resources."""
