"""Watch over the emergency messages of all nodes."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import can
from typing_extensions import override

from handcart.backends.can.bus.errors import Emergency, TwoNodes
from handcart.backends.can.bus.fault_words import fault_words

from .watch import Watch, plain

_EMCY = 0x080
_COLLISION = 0x8150
_NODES = 0x7F


class EmergencyWatch(Watch):
    """Detector of EMCY messages (CiA 301) of any node, except EMCY messages with error codes that the robot's
    file allows.
    """

    def __init__(self, names: Mapping[int, str], allowed: Collection[int]) -> None:
        """Watch a bus; `names` are those of known nodes by node ID, `allowed` are ignored error codes."""
        self._names, self._allowed = names, allowed
        self._seen: tuple[int, int] | None = None
        self._begun = False

    @override
    def begin(self, now: float) -> None:
        self._begun = True

    @override
    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        kind, node = frame.arbitration_id & ~_NODES, frame.arbitration_id & _NODES
        if sent or not self._begun or not plain(frame):
            return
        if kind != _EMCY or node == 0 or len(frame.data) != 8:
            return
        code = int.from_bytes(frame.data[:2], "little")
        if code & 0xFF00 and code not in self._allowed:
            self._seen = self._seen or (node, code)

    @override
    def check(self, now: float) -> None:
        if self._seen is None:
            return
        node, code = self._seen
        name = self._names.get(node, f"node {node}")
        if code == _COLLISION:
            raise TwoNodes(name, f"it says so itself ({code:04X}h)")
        raise Emergency(name, fault_words(code))
