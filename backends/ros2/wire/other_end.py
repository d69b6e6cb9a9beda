"""Drivers at the other end of topics within this process."""

from __future__ import annotations

from typing import Any, Protocol

from handcart.backends.backend import Backend

from .ros_link import Link


class OtherEnd(Protocol):
    """Interface of simulated ROS drivers within this process, which are the other end of the program's
    topics.

    Their time advances with the steps of the program, and no clock is read.
    """

    @property
    def link(self) -> Link:
        """Connection of the robot program to the topics of the ROS drivers."""

    @property
    def inner(self) -> Backend | None:
        """Simulated robot that the simulated drivers control; None without one."""

    def wait(self, seconds: float) -> None:
        """Advance the simulated drivers' time by `seconds` [s] while the program waits, before its first
        step.
        """

    def step(self) -> None:
        """Advance the simulated drivers, and the robot behind them, by one control period."""

    def state(self) -> dict[str, object] | None:
        """Return the state of the simulated robot and its drivers for a checkpoint; None if it cannot be
        saved.
        """

    def set_state(self, state: Any) -> None:
        """Restore a state of the simulated robot and its drivers that `state` returned."""

    def close(self) -> None:
        """Release all resources."""
