"""A bag in place of a robot's drivers, for the backend `ros2`."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.ros2.wire.other_end import OtherEnd

from .bag_link import BagLink


class PlayedBag(OtherEnd):
    """Stand-in for a robot on a ROS connection, which replays recorded messages and ignores all commands.

    The recording advances with the program's control periods.
    """

    def __init__(self, link: BagLink, period: float) -> None:
        """Play a bag; `period` is that of the control, in [s]."""
        self._link, self._period = link, period

    @property
    @override
    def link(self) -> BagLink:
        return self._link

    @property
    @override
    def inner(self) -> Backend | None:
        return None

    @override
    def wait(self, seconds: float) -> None:
        self._link.pass_time(seconds)

    @override
    def step(self) -> None:
        self._link.pass_time(self._period)

    @override
    def state(self) -> dict[str, object] | None:
        return None

    @override
    def set_state(self, state: object) -> None:
        raise AssertionError("a bag keeps no state")

    @override
    def close(self) -> None:
        self._link.close()
