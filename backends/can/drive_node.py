"""A simulated CiA 402 drive."""

from __future__ import annotations

import math
from typing import Any

import canopen
from canopen.pdo import PdoMap

from .drive_dictionary import drive_dictionary
from .drive_life import ENABLED, OFF, QUICK_STOP, REACTION, DriveLife

SYNC = 0x80
SYNCHRONOUS = 240  # transmission types up to here answer a SYNC (CiA 301)
PROFILE_VELOCITY = 3
_TO_REST = 2  # quick stop option code (605Ah): slow down, then SWITCH ON DISABLED
_KEPT = (0x1006, 0x603F, 0x605A, 0x6060, 0x6083, 0x6084, 0x6085, 0x60FF)


class DriveNode(canopen.LocalNode):
    """A motor on a test stand that follows its velocity profile exactly; its position is rounded to counts.

    Its time is the bus's: each SYNC is one communication cycle period (1006h), and no clock is read. A new
    target takes effect when its PDO comes. Without torque (SWITCH ON DISABLED ...) a brake stops it as the
    quick stop does.

    How it differs from metal: no load, no current, no following error, no time-out of the bus; it is
    configured by PDOs without having to disable them first.
    """

    def __init__(self, node: int) -> None:
        """A drive with that node ID, standing at 0."""
        super().__init__(node, drive_dictionary(node))
        self.life = DriveLife()
        self.position = 0.0
        """Where it truly stands, in counts."""
        self.velocity = 0.0
        """In counts/s."""
        self.silent = False
        """Whether it sends no PDOs any more, though it still listens."""
        self._kept = {index: int.from_bytes(self.get_data(index, 0), "little") for index in _KEPT}
        self.add_write_callback(self._written)
        self.add_read_callback(self._read)

    def associate_network(self, network: canopen.Network) -> None:
        """Join a network, and boot up."""
        super().associate_network(network)
        network.subscribe(0, self._on_nmt)
        network.subscribe(SYNC, self._on_sync)
        self.nmt.state = "INITIALISING"
        self.nmt.state = "PRE-OPERATIONAL"

    def fail(self, code: int) -> None:
        """A fault occurs: an EMCY with this error code, and the fault reaction begins."""
        self._kept[0x603F] = code
        self.life.fail()
        self.emcy.send(code, register=1)

    # What comes in

    def _on_nmt(self, *_: object) -> None:
        """Started: take the PDOs as they have been configured."""
        if self.nmt.state != "OPERATIONAL":
            return
        self.pdo.read()
        for pdo in self.rpdo.values():
            if pdo.enabled and self._on_pdo not in pdo.callbacks:
                pdo.add_callback(self._on_pdo)

    def _on_pdo(self, pdo: PdoMap) -> None:
        if self.nmt.state == "OPERATIONAL" and 8 * len(pdo.data) == pdo.length:
            for variable in pdo:
                self._take(variable.index, int(variable.raw))

    def _written(self, index: int, od: Any, data: bytes, **_: object) -> None:
        if index in _KEPT or index == 0x6040:
            self._take(index, int(od.decode_raw(data)))

    def _take(self, index: int, value: int) -> None:
        if index == 0x6040:
            before = self.life.state
            self.life.control(value)
            if before == "FAULT" and self.life.state == OFF:
                self._kept[0x603F] = 0
        else:
            self._kept[index] = value

    # What goes out

    def _read(self, index: int, **_: object) -> int | None:
        return self._value(index)

    def _value(self, index: int) -> int | None:
        match index:
            case 0x6041:
                return self.life.statusword
            case 0x6061:
                return self._kept[0x6060]
            case 0x6064:
                return _wrapped(round(self.position))
            case 0x606C:
                return round(self.velocity)
        return self._kept.get(index)

    def _on_sync(self, *_: object) -> None:
        """A period has passed: move, and tell."""
        self._move(self._kept[0x1006] / 1e6)
        if self.nmt.state != "OPERATIONAL" or self.silent:
            return
        for pdo in self.tpdo.values():
            if pdo.enabled and pdo.trans_type is not None and pdo.trans_type <= SYNCHRONOUS:
                for variable in pdo:
                    variable.raw = self._value(variable.index) or 0
                pdo.transmit()

    def _move(self, seconds: float) -> None:
        driven = self.life.state == ENABLED and self._kept[0x6060] == PROFILE_VELOCITY
        target = float(self._kept[0x60FF]) if driven else 0.0
        slows = abs(target) < abs(self.velocity) or target * self.velocity < 0.0
        rate = self._kept[(0x6084 if slows else 0x6083) if driven else 0x6085]
        way, self.velocity = ramp(self.velocity, target, rate, seconds)
        self.position += way
        if self.velocity != 0.0:
            return
        if self.life.state == REACTION:
            self.life.settle()
        elif self.life.state == QUICK_STOP and self._kept[0x605A] == _TO_REST:
            self.life.disable()


def ramp(velocity: float, target: float, rate: float, seconds: float) -> tuple[float, float]:
    """The way that is covered, and the velocity then, where it goes over to `target` at `rate` a second."""
    needs = abs(target - velocity) / rate if rate > 0.0 else math.inf
    if needs <= seconds:
        return (velocity + target) / 2 * needs + target * (seconds - needs), target
    end = velocity + math.copysign(rate * seconds, target - velocity)
    return (velocity + end) / 2 * seconds, end


def _wrapped(counts: int) -> int:
    """As the 32 bits of a position go over."""
    return (counts + 2**31) % 2**32 - 2**31
