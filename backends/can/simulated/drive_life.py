"""The states of a CiA 402 drive."""

from __future__ import annotations

from typing import Any

from canopen.profiles.p402 import State402
from transitions import Machine

OFF, READY, ON, ENABLED = "SWITCH ON DISABLED", "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED"
QUICK_STOP, REACTION, FAULT = "QUICK STOP ACTIVE", "FAULT REACTION ACTIVE", "FAULT"
_WORKING = [OFF, READY, ON, ENABLED, QUICK_STOP]
DRIVE_STATES = [*_WORKING, REACTION, FAULT]

# CiA 402-2, figure of the finite state automaton; its numbers of transitions behind.
_TRANSITIONS: list[dict[str, Any]] = [
    {"trigger": "_shutdown", "source": [OFF, ON, ENABLED], "dest": READY},  # 2, 6, 8
    {"trigger": "_switch_on", "source": [READY, ENABLED], "dest": ON},  # 3, 5
    {"trigger": "_enable", "source": [ON], "dest": ENABLED},  # 4
    {"trigger": "_enable", "source": [QUICK_STOP], "dest": ENABLED, "conditions": "_stays"},  # 16
    {"trigger": "_disable", "source": [READY, ON, ENABLED, QUICK_STOP], "dest": OFF},  # 7, 10, 9, 12
    {"trigger": "_quick_stop", "source": [ENABLED], "dest": QUICK_STOP},  # 11
    {"trigger": "_quick_stop", "source": [READY, ON], "dest": OFF},  # 7, 10
    {"trigger": "_fail", "source": _WORKING, "dest": REACTION},  # 13
    {"trigger": "_settle", "source": [REACTION], "dest": FAULT},  # 14
    {"trigger": "_reset", "source": [FAULT], "dest": OFF},  # 15
]
_THERE = {
    (transition["trigger"], state)
    for transition in _TRANSITIONS
    for state in DRIVE_STATES
    if state in transition["source"]
}
_STAYING = range(5, 9)  # quick stop option codes (605Ah) that end in QUICK STOP ACTIVE


class DriveLife:
    """State machine of a simulated CiA 402 drive.

    A method whose transition does not exist in the current state does nothing.
    """

    def __init__(self) -> None:
        self._state = OFF
        self._controlword = 0
        self.quick_stop_option = 2
        """Quick stop option code, object 605Ah."""
        self._machine = Machine(
            model=self,
            states=DRIVE_STATES,
            transitions=_TRANSITIONS,
            initial=OFF,
            auto_transitions=False,
            ignore_invalid_triggers=True,
            model_attribute="_state",
        )

    @property
    def state(self) -> str:
        """Name of the simulated drive's present state in CiA 402."""
        return self._state

    @property
    def statusword(self) -> int:
        """Object 6041h: the state, voltage enabled (bit 4) and remote (bit 9)."""
        return int(State402.SW_MASK[self._state][1]) | 0x0210

    def control(self, controlword: int) -> None:
        """Execute the state transition that a controlword (6040h) commands."""
        rising = controlword & ~self._controlword
        self._controlword = controlword
        self._go("_reset" if rising & 0x80 else _trigger(controlword))

    def quick_stop(self) -> None:
        """Begin a quick stop, as if the controlword that commands it had arrived."""
        self._go("_quick_stop")

    def disable(self) -> None:
        """Switch the voltage of the motor off."""
        self._go("_disable")

    def fail(self) -> None:
        """Begin the simulated drive's reaction to a fault (state FAULT REACTION ACTIVE)."""
        self._go("_fail")

    def settle(self) -> None:
        """End a fault reaction or a quick stop when the motion has come to rest."""
        self._go("_settle")
        if self._state == QUICK_STOP and not self._stays():
            self._go("_disable")

    def _stays(self) -> bool:
        return self.quick_stop_option in _STAYING

    def _go(self, trigger: str) -> None:
        if (trigger, self._state) in _THERE:
            getattr(self, trigger)()


def _trigger(controlword: int) -> str:
    """Return the name of the transition that a controlword triggers, by the table of commands in CiA 402-2.

    Bits: 0 switch on, 1 enable voltage, 2 no quick stop, 3 enable operation.
    """
    if not controlword & 0x02:
        return "_disable"
    if not controlword & 0x04:
        return "_quick_stop"
    if not controlword & 0x01:
        return "_shutdown"
    return "_enable" if controlword & 0x08 else "_switch_on"
