"""Cyclic synchronous modes: the master plans, the drive follows from SYNC to SYNC."""

from __future__ import annotations

from typing_extensions import override

from .drive_mode import SETPOINT_TAKEN, DriveMode


class CyclicPosition(DriveMode):
    """CiA 402 mode 8 (CSP) of a simulated drive.

    The drive moves at constant speed to the target position (607Ah) within the interpolation period (60C2h).
    """

    @override
    def begin(self) -> None:
        self._target = self.demand.position
        self.objects[0x607A] = round(self._target + self.demand.home)
        self._left = 0.0

    @override
    def latch(self) -> None:
        lowest, highest = self.objects(0x607D, 1), self.objects(0x607D, 2)
        self._target = min(max(float(self.objects(0x607A)), lowest), highest) - self.demand.home
        self._left = self.objects(0x60C2, 1) * 10.0 ** self.objects(0x60C2, 2)

    @override
    def advance(self, seconds: float) -> None:
        demand, way = self.demand, self._target - self.demand.position
        if seconds >= self._left - 1e-9:
            moved = way
            demand.position = self._target
        else:
            moved = way * seconds / self._left
            demand.position += moved
        self._left = max(0.0, self._left - seconds)
        demand.velocity = moved / seconds if self._left > 0.0 or moved else 0.0

    @property
    def status(self) -> int:
        """Mode's bits of the statusword (6041h): bit 12, which says that the drive follows its set-points."""
        return SETPOINT_TAKEN


class CyclicVelocity(DriveMode):
    """CiA 402 mode 9 (CSV) of a simulated drive, which runs at the target velocity (60FFh) received before
    the last SYNC.
    """

    @override
    def begin(self) -> None:
        self.objects[0x60FF] = 0
        self._target = 0.0

    @override
    def latch(self) -> None:
        most = float(self.objects(0x607F))
        self._target = max(-most, min(most, float(self.objects(0x60FF))))

    @override
    def advance(self, seconds: float) -> None:
        self.demand.velocity = self._target
        self.demand.position += self._target * seconds

    @property
    def status(self) -> int:
        """Bits of the statusword (6041h) that depend on the mode; bit 12 says that the drive follows its
        set-points.
        """
        return SETPOINT_TAKEN

    @property
    @override
    def position_loop(self) -> bool:
        return False
