"""The wheels, with a note of what they were told."""

from __future__ import annotations

from handcart.backends.capabilities.base import Base, WheelTravel


class NotedBase(Base):
    """Passes everything on. A drive command is gone when its period is over, so it is noted here."""

    def __init__(self, base: Base) -> None:
        self._base = base
        self._command = (0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        self._base.drive(speed, turn_rate)
        self._command = (speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return self._base.wheel_travel()

    def taken(self) -> tuple[float, float]:
        """Speed in [m/s] and turn rate in [rad/s] commanded since the last call; zero where nothing was."""
        command, self._command = self._command, (0.0, 0.0)
        return command
