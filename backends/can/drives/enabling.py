"""Bringing drives to OPERATION ENABLED."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import cast

from canopen.profiles.p402 import State402
from canopen.sdo.exceptions import SdoAbortedError

from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.errors import DriveNotReady, WrongDrive
from handcart.backends.can.bus.fault_words import fault_words

from .axis import ENABLED, FAULT, HOLD_COMMAND, QUICK_STOP, Axis, state_of

_WITHIN = 2.0  # [s] that drives may take, brakes included
_LOOKS = 20  # that simulated drives may take
_PAUSE = 0.005  # [s] between two looks
# Command from each state towards OPERATION ENABLED. Only a person resets FAULT.
_NEXT = {
    "SWITCH ON DISABLED": State402.CW_SHUTDOWN,
    "READY TO SWITCH ON": State402.CW_SWITCH_ON,
    "SWITCHED ON": State402.CW_OPERATION_ENABLED,
}


def enable(axes: Sequence[Axis], simulated: bool, beat: Callable[[], None]) -> None:
    """Enable all axes at rest, then let them send and receive PDOs; if one axis fails, none stays enabled.

    Args:
        axes: axes on a network, set up.
        simulated: True for simulated drives, which need no waiting by the wall clock.
        beat: sends this program's heartbeat if it is due.
    """
    try:
        _enable(axes, simulated, beat)
        for axis in axes:
            axis.start()
    except BaseException:
        _withdraw(axes)
        raise


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


def _withdraw(axes: Sequence[Axis]) -> None:
    """Stop the drives that became ready, each in its own way; the caller's error says why others did not.

    An interface that fails for one drive is still tried for the next one.
    """
    for axis in axes:
        word = State402.CW_QUICK_STOP if axis.spec.stop == HOLD_COMMAND else State402.CW_DISABLE_VOLTAGE
        with suppress(Exception):
            axis.leave()
            axis.order(word)
    with suppress(Exception):
        cast(CanLine, axes[0].network).wait(lambda: False, _PAUSE)


def _prepare(axis: Axis) -> str:
    """Set the axis to its present position, so that enabling moves nothing; return `ENABLED`."""
    counts = axis.read(0x6064)
    position, before = axis.units.position(counts), axis.position
    if axis.positioned and abs(position - before) > axis.slack:
        allowed = f"{before:.4g}, as when it was set up: somebody has moved it"
        raise WrongDrive(axis.name, "its position (6064h)", f"{position:.4g}", allowed)
    axis.place(counts, 0, axis.read(0x6077) if axis.tells_torque else 0)
    if not axis.limits.lower - axis.slack <= position <= axis.limits.upper + axis.slack:
        allowed = f"{axis.limits.lower:.4g} to {axis.limits.upper:.4g}: has it lost its reference?"
        raise WrongDrive(axis.name, "its position (6064h)", f"{position:.4g}", allowed)
    axis.write(0x607A if axis.positioned else 0x60FF, 0, counts if axis.positioned else 0)
    axis.stand(position)
    return ENABLED


def _advance(axis: Axis) -> str:
    """Request the drive's next CiA 402 state; return the present one."""
    state = _state(axis)
    if state in (FAULT, "FAULT REACTION ACTIVE"):
        raise DriveNotReady(axis.name, FAULT, _fault(axis))
    if state != ENABLED:
        axis.write(0x6040, 0, _next(axis, state))
        state = _state(axis)
    return state


def _next(axis: Axis, state: str) -> int:
    if state == QUICK_STOP:  # an axis that holds isn't let go of: transition 16
        return int(
            State402.CW_OPERATION_ENABLED if axis.spec.stop == HOLD_COMMAND else State402.CW_DISABLE_VOLTAGE
        )
    return int(_NEXT.get(state, State402.CW_DISABLE_VOLTAGE))


def _state(axis: Axis) -> str:
    return state_of(axis.read(0x6041))


def _fault(axis: Axis) -> str:
    return axis.fault if 0x603F in axis.left_out else fault_words(axis.read(0x603F))


def _asked(axis: Axis, what: Callable[[Axis], str]) -> str:
    try:
        return what(axis)
    except SdoAbortedError as abort:
        raise WrongDrive(axis.name, "its answer", str(abort), "no abort") from None
