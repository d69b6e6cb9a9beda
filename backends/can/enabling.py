"""Bringing drives to OPERATION ENABLED."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import can
from canopen.profiles.p402 import State402
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from .axis import ENABLED, FAULT, HOLD, QUICK_STOP, Axis, state_of
from .errors import BusFault, DriveNotReady, SilentDrive, WrongDrive
from .fault_words import fault_words

_WITHIN = 2.0  # [s] that drives may take, brakes included
_LOOKS = 20  # that simulated drives may take
_PAUSE = 0.005  # [s] between two looks
# What leads from a state towards OPERATION ENABLED; FAULT is a person's to reset.
_NEXT = {
    "SWITCH ON DISABLED": State402.CW_SHUTDOWN,
    "READY TO SWITCH ON": State402.CW_SWITCH_ON,
    "SWITCHED ON": State402.CW_OPERATION_ENABLED,
}


def enable(axes: Sequence[Axis], simulated: bool, beat: Callable[[], None]) -> None:
    """Enable all, standing; then start them on the network. If one isn't ready, none stays enabled.

    Args:
        axes: set up.
        simulated: whether they answer at once, or never.
        beat: sends our heartbeat if it is due.

    Raises:
        DriveNotReady: one has a fault, or doesn't become ready.
        SilentDrive: one doesn't answer.
        WrongDrive: one stands where it can't, or refuses.
    """
    try:
        _enable(axes, simulated, beat)
    except BaseException:
        for axis in axes:
            _withdraw(axis)
        raise
    for axis in axes:
        axis.nmt.state = "OPERATIONAL"


def _enable(axes: Sequence[Axis], simulated: bool, beat: Callable[[], None]) -> None:
    for axis in axes:
        _asked(axis, _prepare)
    end, looks = time.monotonic() + _WITHIN, 0
    while True:
        beat()
        left = [axis for axis in axes if _asked(axis, _advance) != ENABLED]
        if not left:
            break
        looks += 1
        if looks >= _LOOKS if simulated else time.monotonic() > end:
            raise DriveNotReady(left[0].name, _asked(left[0], _state), _asked(left[0], _fault))
        if not simulated:
            time.sleep(_PAUSE)


def _withdraw(axis: Axis) -> None:
    """Not all of them became ready: those that did stop, each in its own way."""
    word = State402.CW_QUICK_STOP if axis.spec.stop == HOLD else State402.CW_DISABLE_VOLTAGE
    with suppress(SdoCommunicationError, SdoAbortedError, can.CanError, BusFault):
        axis.sdo[0x6040].raw = word


def _prepare(axis: Axis) -> str:
    """Nothing is to move when it is enabled."""
    counts = int(axis.sdo[0x6064].raw)
    position, before = axis.units.position(counts), axis.position
    if axis.positioned and abs(position - before) > axis.slack:
        allowed = f"{before:.4g}, as when it was set up: somebody has moved it"
        raise WrongDrive(axis.name, "its position (6064h)", f"{position:.4g}", allowed)
    axis.place(counts, 0, int(axis.sdo[0x6077].raw))
    if not axis.limits.lower - axis.slack <= position <= axis.limits.upper + axis.slack:
        allowed = f"{axis.limits.lower:.4g} to {axis.limits.upper:.4g}: has it lost its reference?"
        raise WrongDrive(axis.name, "its position (6064h)", f"{position:.4g}", allowed)
    axis.sdo[0x607A if axis.positioned else 0x60FF].raw = counts if axis.positioned else 0
    axis.stand(position)
    return ENABLED


def _advance(axis: Axis) -> str:
    """Ask for the next state; gives the one it is in."""
    state = _state(axis)
    if state in (FAULT, "FAULT REACTION ACTIVE"):
        raise DriveNotReady(axis.name, FAULT, _fault(axis))
    if state != ENABLED:
        axis.sdo[0x6040].raw = _next(axis, state)
        state = _state(axis)
    return state


def _next(axis: Axis, state: str) -> int:
    if state == QUICK_STOP:  # an axis that holds isn't let go of: transition 16
        return int(State402.CW_OPERATION_ENABLED if axis.spec.stop == HOLD else State402.CW_DISABLE_VOLTAGE)
    return int(_NEXT.get(state, State402.CW_DISABLE_VOLTAGE))


def _state(axis: Axis) -> str:
    return state_of(int(axis.sdo[0x6041].raw))


def _fault(axis: Axis) -> str:
    return fault_words(int(axis.sdo[0x603F].raw))


def _asked(axis: Axis, what: Callable[[Axis], str]) -> str:
    try:
        return what(axis)
    except SdoCommunicationError:
        raise SilentDrive(axis.name, "answer to an SDO", None) from None
    except SdoAbortedError as abort:
        raise WrongDrive(axis.name, "its answer", str(abort), "no abort") from None
