"""Watch over the CAN controller's own state."""

from __future__ import annotations

from collections.abc import Callable

import can
from typing_extensions import override

from handcart.backends.can.bus.errors import ControllerFault

from .watch import Watch

# linux/can/error.h: classes in the identifier of an error frame; of the controller, in its second byte.
BUS_OFF, CONTROLLER = 0x40, 0x04
_WARNING, _PASSIVE = 0x0C, 0x30
_WARNED_FOR = 1.0  # [s] for which a warning is waited out


class ControllerWatch(Watch):
    """Detector of a CAN controller that is bus-off or error-passive, or in the state warning for 1 s."""

    def __init__(self, state: Callable[[], can.BusState]) -> None:
        """Watch a CAN controller, whose state `state` returns; it is called once a period."""
        self._state = state
        self._trouble = ""
        self._warned: float | None = None

    @override
    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        if not frame.is_error_frame:
            return
        kind = frame.arbitration_id
        detail = frame.data[1] if kind & CONTROLLER and len(frame.data) > 1 else 0
        if kind & BUS_OFF:
            self._trouble = "off the bus (bus-off)"
        elif detail & _PASSIVE:
            self._trouble = self._trouble or "error-passive"
        elif kind & CONTROLLER:
            self._warned = None if not detail & _WARNING else now if self._warned is None else self._warned

    def check(self, now: float) -> None:
        """Raise `ControllerFault` if the CAN controller reports a fault, at a time `now` in [s]."""
        if self._state() is can.BusState.ERROR:
            self._trouble = "off the bus (bus-off)"
        elif self._state() is can.BusState.PASSIVE:
            self._trouble = self._trouble or "error-passive"
        if self._trouble:
            raise ControllerFault(self._trouble)
        if self._warned is not None and now - self._warned >= _WARNED_FOR:
            raise ControllerFault(f"in warning for {now - self._warned:.3g} s")
