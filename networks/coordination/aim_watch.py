"""Watch over a run's time-out, interrupts and rounds."""

from __future__ import annotations

from collections.abc import Mapping

from handcart.backends.capabilities.battery import Battery
from handcart.backends.robot.robot import Robot
from handcart.networks.graph.aims import Aims, Interrupt

CHARGE_HYSTERESIS = 2.0
"""Charge above its limit from which a battery's interrupt may come again, in [%]."""
CHARGE_TIMEOUT_S = 300.0
"""Time without a rise of the charge after which a robot no longer waits for it, in [s]."""


class AimWatch:
    """Says when a round's time is over, when the next one begins, and which interrupt is due.

    All times are the robot's.
    """

    def __init__(self, robot: Robot, aims: Aims, began: float, handled: Mapping[int, float]) -> None:
        """Begin to watch.

        Args:
            robot: the robot.
            aims: aims of the network.
            began: when the round began, in [s].
            handled: when interrupts came last, in [s], by their numbers; for the others, when the run began.
        """
        self._robot, self._aims = robot, aims
        self._round_began = began
        self._handled = {number: handled.get(number, began) for number in range(len(aims.interrupts))}
        self._is_low: dict[int, bool] = {}
        self._charging: Interrupt | None = None
        self._charged, self._rose = -1.0, 0.0
        self._battery: Battery | None = robot.backend.get(Battery)  # type: ignore[type-abstract]

    def begin_round(self) -> float:
        """Return the time at which the next round may begin, in [s]; its time-out counts from then."""
        every = 0.0 if self._aims.rounds is None else self._aims.rounds.every_s
        self._round_began = max(self._robot.time, self._round_began + every)
        return self._round_began

    @property
    def left_s(self) -> float | None:
        """Time that is left for the round, in [s]; None if it is not limited."""
        limit = self._aims.time_out_s
        return None if limit is None else limit - (self._robot.time - self._round_began)

    @property
    def is_early(self) -> bool:
        """True while the round may not begin yet."""
        return self._robot.time < self._round_began

    def due(self, priority: int | None) -> int | None:
        """Return the number of the interrupt that is due, None if none is; each is returned once.

        Args:
            priority: that of the interrupt that is pursued, which has to be exceeded; None: none is.
        """
        numbered = sorted(enumerate(self._aims.interrupts), key=lambda interrupt: -interrupt[1].priority)
        for number, item in numbered:
            above = priority is None or item.priority > priority
            if above and self._is_due(number, item):
                self._handled[number] = self._robot.time
                if item.battery_until is not None:
                    self._charging, self._charged = item, -1.0
                return number
        return None

    def is_charging(self, situation: str) -> bool:
        """Return whether the robot waits in a situation until its battery is charged.

        A charge that does not rise, or is not known, ends the wait.
        """
        wanted = self._charging
        if wanted is None or wanted.battery_until is None or self._battery is None:
            return False
        if situation not in wanted.goals:
            return False
        charge, now = self._battery.charge_percent(), self._robot.time
        if charge > self._charged:
            self._charged, self._rose = charge, now
        if charge < wanted.battery_until and now - self._rose < CHARGE_TIMEOUT_S:
            return True
        self._charging = None
        return False

    def _is_due(self, number: int, interrupt: Interrupt) -> bool:
        if interrupt.every_s is not None:
            return self._robot.time - self._handled[number] >= interrupt.every_s
        if self._battery is None or interrupt.battery_below is None:
            return False
        charge, was_low = self._battery.charge_percent(), self._is_low.get(number, False)
        limit = interrupt.battery_below + (CHARGE_HYSTERESIS if was_low else 0.0)
        self._is_low[number] = charge < limit
        return self._is_low[number] and not was_low
