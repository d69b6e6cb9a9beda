"""Profile position: the drive plans its way to a point."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.can.drives.profile import approach

from .drive_mode import AT_ONCE, NEW_SETPOINT, RELATIVE, SETPOINT_TAKEN, TARGET_REACHED, DriveMode


class ProfilePosition(DriveMode):
    """CiA 402 mode 1 of a simulated drive, with the handshake of CiA 402-2.

    A set-point is accepted when bit 4 of the controlword rises. With bit 5 it applies at once; without bit 5
    it waits until the present set-point is reached. Bit 12 of the statusword is set while the drive cannot
    accept a further set-point.
    """

    @override
    def begin(self) -> None:
        self._target, self._next = self.demand.position, list[float]()
        self._taken = self._asked = False

    @override
    def control(self, controlword: int, rising: int) -> None:
        self._asked = bool(controlword & NEW_SETPOINT)
        if rising & NEW_SETPOINT and not self._taken:
            self._take(controlword)
        self._taken = (self._taken and self._asked) or bool(self._next)

    def _take(self, controlword: int) -> None:
        wanted = float(self.objects(0x607A))
        if controlword & RELATIVE:
            wanted += self._target + self.demand.home
        lowest, highest = self.objects(0x607D, 1), self.objects(0x607D, 2)
        wanted = min(max(wanted, lowest), highest) - self.demand.home
        if controlword & AT_ONCE or self._target == self.demand.position:
            self._target, self._next = wanted, []
        else:
            self._next = [wanted]
        self._taken = True

    @override
    def advance(self, seconds: float) -> None:
        demand = self.demand
        top = min(self.objects(0x6081), self.objects(0x607F))
        rates = float(self.objects(0x6083)), float(self.objects(0x6084))
        left, demand.velocity = approach(
            self._target - demand.position, demand.velocity, float(top), rates, seconds
        )
        demand.position = self._target - left
        if left == 0.0 and self._next:
            self._target, self._next = self._next[0], []
            self._taken = self._asked

    @property
    @override
    def status(self) -> int:
        reached = self._target == self.demand.position and not self._next
        return TARGET_REACHED * reached | SETPOINT_TAKEN * self._taken
