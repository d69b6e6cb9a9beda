"""The life of a simulated node on the network."""

from __future__ import annotations

from canopen.nmt import NmtSlave


class DriveNmt(NmtSlave):
    """NMT slave of canopen for a simulated drive, with heartbeats by simulated time instead of by a
    thread.
    """

    def start_heartbeat(self, heartbeat_time_ms: int) -> None:
        """Begin to send a heartbeat in each interval of `heartbeat_time_ms` [ms] of simulated time; 0 sends
        none.
        """
        self._heartbeat_time_ms = heartbeat_time_ms
        self._waited = 0.0

    def advance(self, seconds: float) -> bool:
        """Advance the simulated time by `seconds` [s]; return True if a heartbeat is due."""
        if self._heartbeat_time_ms == 0 or self.state == "INITIALISING":
            return False
        self._waited += 1e3 * seconds
        if self._waited < self._heartbeat_time_ms - 1e-6:
            return False
        self._waited = 0.0
        return True

    def beat(self) -> None:
        """Send a CANopen heartbeat of the simulated drive."""
        self.network.send_message(0x700 + self.id, bytes([self._state]))
