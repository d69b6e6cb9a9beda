"""Profile velocity: the drive ramps to a speed."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.can.drives.profile import ramp

from .drive_mode import TARGET_REACHED, DriveMode


class ProfileVelocity(DriveMode):
    """CiA 402 mode 3 of a simulated drive.

    Its speed ramps to the target velocity (60FFh) with acceleration 6083h and deceleration 6084h.
    """

    @override
    def begin(self) -> None:
        self.objects[0x60FF] = 0

    @override
    def advance(self, seconds: float) -> None:
        demand, most = self.demand, float(self.objects(0x607F))
        target = max(-most, min(most, float(self.objects(0x60FF))))
        slows = abs(target) < abs(demand.velocity) or target * demand.velocity < 0.0
        way, demand.velocity = ramp(
            demand.velocity, target, self.objects(0x6084 if slows else 0x6083), seconds
        )
        demand.position += way

    @property
    @override
    def status(self) -> int:
        return TARGET_REACHED if self.demand.velocity == self.objects(0x60FF) else 0

    @property
    @override
    def position_loop(self) -> bool:
        return False
