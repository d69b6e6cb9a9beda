"""Profile velocity: the drive ramps to a speed."""

from __future__ import annotations

from handcart.backends.can.drives.profile import ramp

from .drive_mode import TARGET_REACHED, DriveMode


class ProfileVelocity(DriveMode):
    """Mode 3: goes over to the target velocity (60FFh) by 6083h and 6084h."""

    def begin(self) -> None:
        """See `DriveMode`."""
        self.objects[0x60FF] = 0

    def advance(self, seconds: float) -> None:
        """See `DriveMode`."""
        demand, most = self.demand, float(self.objects(0x607F))
        target = max(-most, min(most, float(self.objects(0x60FF))))
        slows = abs(target) < abs(demand.velocity) or target * demand.velocity < 0.0
        way, demand.velocity = ramp(
            demand.velocity, target, self.objects(0x6084 if slows else 0x6083), seconds
        )
        demand.position += way

    @property
    def status(self) -> int:
        """See `DriveMode`."""
        return TARGET_REACHED if self.demand.velocity == self.objects(0x60FF) else 0

    @property
    def position_loop(self) -> bool:
        """See `DriveMode`."""
        return False
