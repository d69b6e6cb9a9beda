"""Homing: finding where zero is."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.can.drives.profile import ramp

from .drive_mode import NEW_SETPOINT, SETPOINT_TAKEN, TARGET_REACHED, DriveMode

HOME_HERE_METHODS = (35, 37)
"""Homing methods that make the current position home."""
NEGATIVE_SWITCH = 17
"""Homing method that moves to the negative limit switch, and back until it opens, which is home."""
_FAILED = 1 << 13


class Homing(DriveMode):
    """CiA 402 mode 6 of a simulated drive, with the homing methods 17, 35 and 37 (6098h).

    Homing begins when bit 4 of the controlword rises. At the home position, the position actual value (6064h)
    is set to the home offset (607Ch).
    """

    @override
    def begin(self) -> None:
        self._searching = self._backing = self._done = self._failed = False

    @override
    def control(self, controlword: int, rising: int) -> None:
        if not rising & NEW_SETPOINT:
            self._searching = self._searching and bool(controlword & NEW_SETPOINT)
            return
        self.begin()
        method = self.objects(0x6098)
        self._failed = method not in (*HOME_HERE_METHODS, NEGATIVE_SWITCH)
        self._searching = method == NEGATIVE_SWITCH
        if method in HOME_HERE_METHODS:
            self._arrived(self.demand.position)

    @override
    def advance(self, seconds: float) -> None:
        demand = self.demand
        pressed = demand.position <= demand.switch
        self._backing = self._searching and (self._backing or pressed)
        if self._backing and not pressed:
            self._searching = self._backing = False
            self._arrived(demand.switch)
        goal = 0.0
        if self._searching:
            goal = float(self.objects(0x6099, 2)) if self._backing else -float(self.objects(0x6099, 1))
        way, demand.velocity = ramp(demand.velocity, goal, self.objects(0x609A), seconds)
        demand.position += way

    def _arrived(self, place: float) -> None:
        self.demand.home = self.objects(0x607C) - place
        self._done = True

    @property
    @override
    def status(self) -> int:
        stands = self.demand.velocity == 0.0 and not self._searching
        return SETPOINT_TAKEN * self._done | TARGET_REACHED * stands | _FAILED * self._failed
