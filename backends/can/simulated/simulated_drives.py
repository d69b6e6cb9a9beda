"""Simulated drives on a bus."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import can
from can.interfaces.virtual import VirtualBus
from canopen.objectdictionary import ObjectDictionary

from handcart.backends.can.bus.can_line import CanLine

from .drive_node import DriveNode
from .plant import IdealMotors, Plant

SYNC_COB_ID = 0x80


class SimulatedDrives:
    """Simulated drives on one CAN bus, which run in the thread of their caller.

    Each SYNC advances their time by one period; no clock is read.
    """

    def __init__(
        self,
        nodes: Iterable[int],
        period: float,
        plant: Plant | None = None,
        bus: can.BusABC | None = None,
        dictionaries: Mapping[int, ObjectDictionary] | None = None,
    ) -> None:
        """Put drives with these node IDs on a bus.

        Args:
            nodes: node IDs.
            period: duration that a SYNC represents, in [s].
            plant: load that the drives turn; None: only their motors.
            bus: bus that is taken over; None: a new virtual bus.
            dictionaries: objects of drives by node ID; others have those of our own EDS.
        """
        self._period, self._plant = period, plant or IdealMotors()
        self._channel = f"drives {id(self):#x}"
        self.line = CanLine(bus or VirtualBus(self._channel))
        """The drives' end of the bus."""
        described = dictionaries or {}
        self.nodes = {node: DriveNode(node, described.get(node)) for node in nodes}
        """The drives by their node IDs."""
        self.time = 0.0
        """Simulated time, in [s]."""
        self.onlookers: list[Callable[[], None]] = []
        """Functions that are called at the beginning of each period."""
        for number, drive in self.nodes.items():
            self.line[number] = drive
        self.line.subscribe(SYNC_COB_ID, self._on_sync)

    def open(self) -> can.BusABC:
        """Return a new connection to the drives' virtual bus, for a client."""
        return VirtualBus(self._channel)

    def serve(self) -> None:
        """Let the drives receive and answer all frames sent to them."""
        self.line.drain()

    def tick(self, seconds: float) -> None:
        """Advance the simulated drives and the mechanics that they move by `seconds` [s], without a SYNC."""
        self.time += seconds
        for look in self.onlookers:
            look()
        for drive in self.nodes.values():
            drive.advance(seconds)
        self._plant.step(self.nodes, seconds)

    def close(self) -> None:
        """Close the drives' connection to the bus. A second call does nothing."""
        self.line.close()

    def _on_sync(self, *_: object) -> None:
        self.tick(self._period)
        for drive in self.nodes.values():
            drive.latch()
            drive.answer()
