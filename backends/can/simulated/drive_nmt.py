"""The life of a simulated node on the network."""

from __future__ import annotations

from canopen.nmt import NmtSlave


class DriveNmt(NmtSlave):
    """canopen's NMT slave, whose heartbeats are sent as simulated time passes instead of by a thread."""

    def start_heartbeat(self, heartbeat_time_ms: int) -> None:
        """Send a heartbeat once per interval, in [ms] of simulated time; 0: none."""
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
        """Send a heartbeat."""
        self.network.send_message(0x700 + self.id, bytes([self._state]))
