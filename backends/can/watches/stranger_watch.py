"""Watch over commands to the drives from another node."""

from __future__ import annotations

from collections.abc import Iterable

import can
from typing_extensions import override

from handcart.backends.can.bus.errors import Stranger

from .watch import Watch, plain

_NMT, _SYNC = 0x000, 0x080
_COMMANDS = (0x200, 0x300, 0x400, 0x500, 0x600)  # RPDOs and SDO requests, + node
_HEARTBEAT = 0x700


class StrangerWatch(Watch):
    """Detector of a second master, by frames that only a master sends but this program has not sent.

    CAN frames do not contain their sender, so that a frame is detected only after it has reached the drives.
    """

    def __init__(self, nodes: Iterable[int], our_node: int) -> None:
        """Watch over drives with these node IDs; `our_node` is this program's."""
        commands = {first + node for first in _COMMANDS for node in nodes}
        self._ours = {_NMT, _SYNC, _HEARTBEAT + our_node, *commands}
        self._seen: can.Message | None = None

    @override
    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        if not sent and plain(frame) and frame.arbitration_id in self._ours:
            self._seen = self._seen or frame

    def check(self, now: float) -> None:
        """Raise `Stranger` if a frame was received that only another bus master can have sent; `now` is not
        used.
        """
        if self._seen is not None:
            data = self._seen.data.hex(" ")
            raise Stranger(f"a master's frame, {self._seen.arbitration_id:03X}h [{data}]")
