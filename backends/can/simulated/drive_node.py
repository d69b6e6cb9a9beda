"""A simulated CiA 402 drive."""

from __future__ import annotations

import struct
from typing import Any

import canopen
from canopen.objectdictionary import ObjectDictionary
from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.pdo import PdoMap
from canopen.sdo.exceptions import SdoAbortedError

from handcart.backends.can.drives.position_range import INTEGER32_RANGE, RANGE_LIMIT, PositionRange, narrowed

from .cyclic_modes import CyclicPosition, CyclicVelocity
from .drive_faults import DriveFaults
from .drive_life import ENABLED, OFF, QUICK_STOP, REACTION, DriveLife
from .drive_mode import Demand, DriveMode
from .drive_nmt import DriveNmt
from .drive_objects import DriveObjects
from .homing import Homing
from .profile_position import ProfilePosition
from .profile_velocity import ProfileVelocity

MAX_SYNCHRONOUS_TYPE = 240  # transmission types up to here wait for a SYNC (CiA 301)
_MODES: dict[int, type[DriveMode]] = {
    1: ProfilePosition,
    3: ProfileVelocity,
    6: Homing,
    8: CyclicPosition,
    9: CyclicVelocity,
}
_BY_PDO = (0x6040, 0x6060, 0x607A, 0x6081, 0x60FF)
_SUPPORTED = 0x6502  # bit n - 1: mode n
_NO_OBJECT, _NO_SUBINDEX, _NO_VALUE = 0x06020000, 0x06090011, 0x06090030
"""Abort codes (CiA 301)."""
_SLICE = 5e-3  # in which a drive looks at its timers [s]
HEARTBEAT_LOST, RPDO_LATE, FOLLOWING = 0x8130, 0x8250, 0x8611
"""Error codes (603Fh)."""


class DriveNode(canopen.LocalNode):
    """A simulated servo drive with state machine, motion modes, homing, and supervision of bus and motor.

    The drive reads no clock: `advance` advances its time. At each SYNC, `latch` and `answer` are called.
    `driven` is the set-point of the motor; `moved` sets the position that the motor reached (see `Plant`).
    Without torque (SWITCH ON DISABLED ...) a brake stops the motor as the quick stop does, and holds it.

    SDO access to objects that the drive's EDS lacks is aborted, and modes that 6502h lacks cannot be
    selected.

    Differences from real drives: the motor of a `Plant` has no current; any setting is accepted in any state;
    following errors are supervised only in position modes; the only digital input is the negative limit
    switch.
    """

    def __init__(self, node: int, dictionary: ObjectDictionary | None = None) -> None:
        """Create a drive with a node ID, at position 0; its objects are by a maker's EDS, or by our own."""
        self.objects = DriveObjects(node, dictionary)
        super().__init__(node, self.objects.dictionary)
        self.number = node
        """Node ID of the drive."""
        self.beats = DriveNmt(node, self)
        self.nmt = self.beats
        self._write_callbacks = [self.nmt.on_write, self._written]
        self.add_read_callback(self._read)
        self.wrong = DriveFaults()
        """Faults of the drive."""
        self.position = 0.0
        """True position of the motor, in [counts]; homing does not change it."""
        self.torque = 0
        """Torque of the motor, in thousandths of the rated torque."""
        self.driven = 0.0
        """Set-point of the motor, in [counts]."""
        self.velocity = 0.0
        """Velocity of the motor, in [counts/s]."""
        self.pressed = False
        """True if the drive's E-stop input is pressed, which removes the torque."""
        self._power_on()

    def _power_on(self) -> None:
        self.life = DriveLife()
        self.objects.reset()
        self.demand = Demand(self.position)
        self._modes = {mode: kind(self.objects, self.demand) for mode, kind in _MODES.items()}
        self._mode = 0
        self._controlword = 0
        self._reported = 0, 0
        self._off_for = 0.0
        self._heard: float | None = None
        """Time since the last heartbeat of the watched node, in [s]; None before the first."""
        self._commanded: float | None = None
        """Time since the drive's last RPDO, in [s]; None before the first."""
        self._waiting: list[tuple[int, int, int]] = []

    def associate_network(self, network: canopen.Network) -> None:
        """Join a network with the simulated drive, and send its boot-up message."""
        super().associate_network(network)
        network.subscribe(0, self._on_nmt)
        for master in range(1, 128):
            network.subscribe(0x700 + master, self._on_heartbeat)
        self.boot()

    def boot(self) -> None:
        """Restart the drive as after power on: settings are at their defaults, NMT state PRE-OPERATIONAL."""
        self._power_on()
        self.data_store.clear()
        self.nmt.start_heartbeat(0)
        self.nmt.state = "INITIALISING"
        self.nmt.state = "PRE-OPERATIONAL"

    def stand_at(self, position: float) -> None:
        """Set the motor to rest at a position in [counts], before the drive is enabled."""
        self.position = self.driven = self.demand.position = position

    def fail(self, code: int) -> None:
        """Raise a fault: send an EMCY with this error code, and begin the fault reaction."""
        self.objects[0x603F] = code
        self.life.fail()
        self.emcy.send(code, register=1)

    # Received frames

    def _on_nmt(self, _can_id: int, data: bytearray, _stamp: float) -> None:
        command, node = data[0], data[1]
        if node not in (0, self.id):
            return
        if command in (129, 130):
            self.boot()
        elif self.nmt.state == "OPERATIONAL":
            self._commanded = None
            self.pdo.read()
            for pdo in self.rpdo.values():
                if pdo.enabled and self._on_pdo not in pdo.callbacks:
                    pdo.add_callback(self._on_pdo)

    def _on_heartbeat(self, can_id: int, _data: bytearray, _stamp: float) -> None:
        if can_id - 0x700 == self.objects(0x1016, 1) >> 16:
            self._heard = 0.0

    def _on_pdo(self, pdo: PdoMap) -> None:
        if self.nmt.state != "OPERATIONAL" or 8 * len(pdo.data) != pdo.length:
            return
        self._commanded = 0.0
        values = [(item.index, item.subindex, int(item.raw)) for item in pdo]
        # A new set-point comes with the controlword that makes it count.
        values.sort(key=lambda value: value[0] == 0x6040)
        if (pdo.trans_type or 0) <= MAX_SYNCHRONOUS_TYPE:
            self._waiting = values
        else:
            self._take_all(values)

    def get_data(self, index: int, subindex: int, check_readable: bool = False) -> bytes:
        """Return an object's data, as canopen's node does; abort the SDO transfer if the EDS lacks index or
        sub-index.
        """
        self._check_there(index, subindex)
        return super().get_data(index, subindex, check_readable)

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        """Set an object's data, as canopen's node does; abort if the EDS lacks index or sub-index."""
        self._check_there(index, subindex)
        super().set_data(index, subindex, data, check_writable)

    def _check_there(self, index: int, subindex: int) -> None:
        if not self.objects.described(index, subindex):
            there = index in self.object_dictionary
            raise SdoAbortedError(_NO_SUBINDEX if there else _NO_OBJECT)

    def _written(self, index: int, subindex: int, od: Any, data: bytes) -> None:
        if od.data_type not in INTEGER_TYPES:
            return
        value = int(od.decode_raw(data))
        if index == 0x6060 and value != 0 and not self._has_mode(value):
            raise SdoAbortedError(_NO_VALUE)
        self._take_all([(index, subindex, self.wrong.keeps.get((index, subindex), value))])

    def _take_all(self, values: list[tuple[int, int, int]]) -> None:
        for index, subindex, value in values:
            self.objects[index, subindex] = value
            if index == 0x6040:
                self._control(value)
            elif index == 0x6060:
                self._change_mode(value)
            elif index == 0x605A:
                self.life.quick_stop_option = value

    def _control(self, value: int) -> None:
        before, rising = self.life.state, value & ~self._controlword
        self._controlword = value
        if not self.pressed or value & 0x0F != 0x0F:
            self.life.control(value)
        if before == "FAULT" and self.life.state == OFF:
            self.objects[0x603F] = 0
            self.emcy.reset()
        mode = self._modes.get(self._mode)
        if mode is not None and self.life.state == ENABLED:
            if before != ENABLED:
                mode.begin()
            mode.control(value, rising)

    def _has_mode(self, number: int) -> bool:
        return number in self._modes and bool(self.objects(_SUPPORTED) >> (number - 1) & 1)

    def _change_mode(self, number: int) -> None:
        if self._has_mode(number) and number != self._mode:
            self._mode = number
            self._modes[number].begin()

    # Time

    def advance(self, seconds: float) -> None:
        """Advance the drive by `seconds` [s]: plan the motor's motion, and supervise bus and motor."""
        before, left = self.demand.position, seconds
        while left > 1e-9:
            part = min(_SLICE, left)
            left -= part
            self._plan(part)
            self._supervise(part)
            if self.beats.advance(part) and not self.wrong.no_heartbeat:
                self.beats.beat()
        self.driven = self.demand.position + self.wrong.astray(self.demand.position - before)

    def moved(self, position: float, seconds: float, torque: int) -> None:
        """Set the position of the motor, and the torque that the drive reports.

        Args:
            position: position reached, in [counts].
            seconds: time in which it was reached, in [s].
            torque: in thousandths of the rated torque, positive in the direction in which the counts grow.
        """
        self.velocity = (position - self.position) / seconds
        self.position, self.torque = position, torque
        off = abs(self.demand.position - position) > self.objects(0x6065)
        mode = self._modes.get(self._mode)
        watched = mode is not None and mode.position_loop and self.wrong.notices
        self._off_for = self._off_for + seconds if off and watched and self.life.state == ENABLED else 0.0
        if self._off_for * 1e3 > self.objects(0x6066) > 0:
            self.fail(FOLLOWING)

    def _plan(self, seconds: float) -> None:
        mode = self._modes.get(self._mode)
        if self.life.state == ENABLED and mode is not None:
            mode.advance(seconds)
            return
        self.demand.brake(self.objects(0x6085), seconds)
        if self.demand.velocity == 0.0 and self.life.state in (QUICK_STOP, REACTION):
            self.life.settle()

    def _supervise(self, seconds: float) -> None:
        if self.pressed and self.life.state == ENABLED:
            self.life.disable()
        if self._heard is not None:
            self._heard += seconds
            allowed = (self.objects(0x1016, 1) & 0xFFFF) / 1e3
            if 0.0 < allowed < self._heard - 1e-9:
                self._heard = None
                self._lost(HEARTBEAT_LOST)
        if self._commanded is not None and self.nmt.state == "OPERATIONAL":
            self._commanded += seconds
            if 0 < self.objects(0x1400, 5) < 1e3 * self._commanded - 1e-6:
                self._commanded = None
                self._lost(RPDO_LATE)

    def _lost(self, code: int) -> None:
        """React to a missing master as the objects 6007h (abort connection) and 1029h:1 (error behaviour)
        state.

        Args:
            code: error code (603Fh) of the emergency message.
        """
        self.emcy.send(code, register=0x11)
        match self.objects(0x6007):
            case 1:
                self.objects[0x603F] = code
                self.life.fail()
            case 2:
                self.life.disable()
            case 3:
                self.life.quick_stop()
        becomes = {0: "PRE-OPERATIONAL", 2: "STOPPED"}.get(self.objects(0x1029, 1))
        if becomes is not None and self.nmt.state == "OPERATIONAL":
            self.nmt.state = becomes

    def latch(self) -> None:
        """Apply the set-points of synchronous PDOs that were received before the SYNC that has
        just arrived.
        """
        waiting, self._waiting = self._waiting, []
        self._take_all(waiting)
        mode = self._modes.get(self._mode)
        if mode is not None and self.life.state == ENABLED:
            mode.latch()

    # Sent frames

    def answer(self) -> None:
        """Send the PDOs that answer a SYNC."""
        if self.nmt.state != "OPERATIONAL" or self.wrong.silent or self.wrong.lost():
            return
        if not self.wrong.frozen:
            self._reported = self._position(), round(self.velocity)
        for pdo in self.tpdo.values():
            if pdo.enabled and pdo.trans_type is not None and pdo.trans_type <= MAX_SYNCHRONOUS_TYPE:
                for variable in pdo:
                    variable.raw = self._value(variable.index) or 0
                if self.wrong.short:
                    self.network.send_message(pdo.cob_id, bytes(pdo.data[:-1]))
                else:
                    pdo.transmit()

    def _position(self) -> int:
        if self.wrong.jumps_in_turn:
            self.wrong.jump = -self.wrong.jump
        counted = narrowed(INTEGER32_RANGE, self.objects(RANGE_LIMIT, 1), self.objects(RANGE_LIMIT, 2))
        reported = _wrapped(round(self.position + self.demand.home) + self.wrong.jump, counted)
        half = self.wrong.wraps // 2
        return _wrapped(reported, PositionRange(-half, half - 1)) if half else reported

    def _read(self, index: int, subindex: int, od: Any) -> int | None:
        if subindex == 0:
            dynamic = self._value(index)
            if dynamic is not None:
                return dynamic
        if (index, subindex) in self.wrong.keeps:
            return self.wrong.keeps[index, subindex]
        if index in _BY_PDO:
            return self.objects(index)
        if index == RANGE_LIMIT:
            return self.objects(index, subindex)
        unknown = od.value is None and not isinstance(od.default, int) and od.data_type in INTEGER_TYPES
        written = subindex in self.data_store.get(index, {})
        return self.objects(index, subindex) if unknown and not written else None

    def _value(self, index: int) -> int | None:
        match index:
            case 0x6041:
                mode = self._modes.get(self._mode)
                own = mode.status if mode is not None and self.life.state == ENABLED else 0
                return self.life.statusword | own
            case 0x6061:
                return self._mode
            case 0x6062:
                return round(self.demand.position + self.demand.home)
            case 0x6064:
                return self._reported[0] if self.wrong.frozen else self._position()
            case 0x606C:
                return self._reported[1] if self.wrong.frozen else round(self.velocity)
            case 0x6077:
                return self.torque
            case 0x60F4:
                return round(self.demand.position - self.position)
            case 0x60FD:
                return int(self.position <= self.demand.switch)
            case 0x603F:
                return self.objects(index)
        return None


def _wrapped(counts: int, counted: PositionRange) -> int:
    """Return counts wrapped into the range in which the drive counts (607Bh)."""
    return (counts - counted.lowest) % counted.size + counted.lowest


def nmt_reset(node: int) -> bytes:
    """Return the NMT message "reset node" to a node, as data of a CAN frame."""
    return struct.pack("BB", 129, node)
