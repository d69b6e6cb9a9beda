"""The drives behind the interface `virtual`."""

from __future__ import annotations

import can
from can.interfaces.virtual import VirtualBus

from .can_line import CanLine
from .drive_node import DriveNode


class SimulatedDrives:
    """Simulated drives on a virtual bus of their own, served in the thread of who talks to them."""

    def __init__(self, *nodes: int) -> None:
        """Put drives with these node IDs on a bus."""
        self._channel = f"drives {id(self):#x}"
        self._line = CanLine(VirtualBus(self._channel))
        self.nodes = {node: DriveNode(node) for node in nodes}
        """The drives by their node IDs."""
        for number, drive in self.nodes.items():
            self._line[number] = drive

    def open(self) -> can.BusABC:
        """Another end of their bus, for who talks to them."""
        return VirtualBus(self._channel)

    def serve(self) -> None:
        """Let the drives take in, and answer, all that has been sent to them."""
        self._line.drain()

    def close(self) -> None:
        """Leave the bus. A second call does nothing."""
        self._line.close()
