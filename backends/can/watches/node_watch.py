"""Watch over the drives: each is there, once, and has not restarted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import can
from typing_extensions import override

from handcart.backends.can.bus.errors import CanFault, NodeRestarted, SilentDrive, TwoNodes

from .watch import Watch, plain

SYNC, FIRST_ANSWER, SDO_ANSWER, SDO_REQUEST, HEARTBEAT = 0x080, 0x180, 0x580, 0x600, 0x700
BOOTED, OPERATIONAL = 0, 5
_STATES = {4: "is STOPPED", 127: "is PRE-OPERATIONAL"}
_NODES = 0x7F


class NodeWatch(Watch):
    """Detector of missing heartbeats, of boot-up messages, and of two nodes with the same node ID."""

    def __init__(self, names: Mapping[int, str], allowed: float) -> None:
        """Watch nodes.

        Args:
            names: names of the nodes, by node ID.
            allowed: longest time without a heartbeat, in [s].
        """
        self._names, self._allowed = names, allowed
        self._begun = False
        self._set: set[int] = set()
        """Nodes that were written to or read: after a boot they have lost their settings."""
        self._last: dict[int, float] = {}
        self._answers: Counter[int] = Counter()
        self._open: Counter[int] = Counter()
        self._trouble: CanFault | None = None

    @override
    def begin(self, now: float) -> None:
        self._begun = True
        self._last = dict.fromkeys(self._names, now)

    @override
    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        if not plain(frame):
            return
        kind, node = frame.arbitration_id & ~_NODES, frame.arbitration_id & _NODES
        if sent:
            self._sent(frame.arbitration_id, kind, node)
        elif node in self._names:
            self._came(kind, node, frame, now)

    def _sent(self, can_id: int, kind: int, node: int) -> None:
        if can_id == SYNC:
            self._answers.clear()
        elif kind == SDO_REQUEST:
            self._open[node] += 1
            self._set.add(node)

    def _came(self, kind: int, node: int, frame: can.Message, now: float) -> None:
        if kind == HEARTBEAT and len(frame.data) == 1:
            if self._begun:
                self._last[node] = now
            self._state(node, frame.data[0] & _NODES)
        elif kind == FIRST_ANSWER:
            self._answers[node] += 1
            if self._answers[node] > 1:
                self._wrong(TwoNodes(self._names[node], "two answers to one SYNC"))
        elif kind == SDO_ANSWER:
            self._open[node] -= 1
            if self._open[node] < 0:
                self._wrong(TwoNodes(self._names[node], "two answers to one SDO request"))

    def _state(self, node: int, state: int) -> None:
        matters = node in self._set if state == BOOTED else self._begun
        if not matters or state == OPERATIONAL:
            return
        what = "has booted" if state == BOOTED else _STATES.get(state, f"is in the state {state}")
        self._wrong(NodeRestarted(self._names[node], what))

    def _wrong(self, fault: CanFault) -> None:
        self._trouble = self._trouble or fault

    @override
    def check(self, now: float) -> None:
        if self._trouble is not None:
            raise self._trouble
        for node, last in self._last.items():
            if now - last > self._allowed + 1e-9:
                raise SilentDrive(self._names[node], "heartbeat (700h)", now - last)
