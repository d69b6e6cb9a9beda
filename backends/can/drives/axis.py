"""One drive, as the robot commands it."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import canopen
from canopen.objectdictionary import ObjectDictionary, ObjectDictionaryError
from canopen.pdo import PdoMap
from canopen.profiles.p402 import State402
from canopen.sdo.base import SdoVariable
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoCommunicationError

from handcart.backends.can.bus.errors import SilentDrive, TooManyCounts, WrongDrive
from handcart.backends.can.bus.fault_words import fault_words
from handcart.backends.can.bus.line_sdo_client import LineSdoClient, NoAnswer
from handcart.backends.can.bus.pdo_layout import CYCLIC_POSITION, PROFILE_POSITION, Pdo, layout
from handcart.backends.can.bus.pdo_mapping import map_objects, save_mapping
from handcart.backends.can.eds.lacks import left_out
from handcart.backends.description.can_spec import AxisSpec

from .axis_limits import AxisLimits
from .axis_units import AxisUnits, unwrapped
from .expected_motion import ExpectedMotion
from .position_jumps import PositionJumps, encoder_bits
from .position_range import INTEGER32_RANGE, PositionRange

ENABLED, FAULT, QUICK_STOP = "OPERATION ENABLED", "FAULT", "QUICK STOP ACTIVE"
HOLD_COMMAND = "hold"
NEW_SETPOINT, AT_ONCE = 1 << 4, 1 << 5
SETPOINT_TAKEN = 1 << 12
_START, _PREPARE = 0x01, 0x80  # NMT commands (CiA 301)
_WRITE_WORD = 0x2B  # command of an SDO that writes two bytes (CiA 301)
_STANDS = 0.01  # ratio of the top speed; a slower axis is at rest
_CREEP = 0.01  # of top speed: no way is planned slower


class Axis(canopen.RemoteNode):
    """A CiA 402 drive in one mode of operation, with its commands and readings.

    Positions are in [m] for a wheel's rim, the fingers' opening or a sliding joint, in [rad] for a turning
    joint.
    """

    def __init__(
        self,
        name: str,
        spec: AxisSpec,
        mode: int,
        units: AxisUnits,
        limits: AxisLimits,
        dictionary: ObjectDictionary,
        period: float,
    ) -> None:
        """Create a drive that is not on a network yet.

        Args:
            name: name of the axis for people.
            spec: from the robot's file.
            mode: mode of operation (6060h).
            units: units of the axis.
            limits: limits of the axis.
            dictionary: objects of the drive.
            period: time between two SYNCs, in [s].

        Raises:
            TooManyCounts: a possible command does not fit into 32 bits.
        """
        super().__init__(spec.node, dictionary)
        self.name = f"the {name} drive (node {spec.node})"
        self.spec, self.mode, self.units, self.limits, self.period = spec, mode, units, limits, period
        most = max(limits.speed, limits.acceleration, limits.braking) * abs(units.scale)
        ends = [units.counts(item) for item in (limits.lower, limits.upper) if math.isfinite(item)]
        if not max([most, *map(abs, ends)]) < 2**31:
            raise TooManyCounts(self.name, max([most, *map(abs, ends)]))
        self.positioned = mode in (PROFILE_POSITION, CYCLIC_POSITION)
        """True if the axis' commands are positions, False if they are speeds."""
        self.left_out = left_out(spec)
        """Objects that the drive lacks, with which the axis does without."""
        self.layout = layout(mode, self.left_out)
        self.expected = ExpectedMotion(mode, limits)
        """Motion expected from the commands."""
        self._target, self._top = 0.0, limits.speed
        self._sent: int | None = None
        self._asks = False
        self._fresh: set[int] = set()
        self._asked = self._answered = 0
        self._counts: int | None = None
        self.counted: PositionRange = INTEGER32_RANGE
        """Range in which the drive counts, as it reports it."""
        self._jumps = PositionJumps(limits, units.scale, period)
        self._taken = 0
        """Number of the SYNC whose answer had the last possible position."""
        self._jump, self._jump_way = 0, 0.0
        self._reported_travel = 0.0
        """Travel since that SYNC by the reported velocities, in [counts]."""
        self.odd = 0
        """Number of impossible positions in a row."""
        self.ignored = 0
        """Number of set-points in a row that the drive has not accepted."""
        self._reported = dict.fromkeys(
            (index for answer in self.layout.answers for index in answer.objects), 0
        )
        self.travel = 0.0
        """Travel since the object was created, in [m] or [rad]."""
        self.contradiction = 0.0
        """Travel by the positions less that by the reported velocities, in [m] or [rad]."""
        for pdo, planned in zip(self._commands, self.layout.commands, strict=False):
            map_objects(pdo, planned.objects, planned.transmission)
        for pdo, planned in zip(self._answers, self.layout.answers, strict=True):
            map_objects(pdo, planned.objects, planned.transmission)
            pdo.rtr_allowed = False
            pdo.add_callback(self._on_answer)

    @property
    def _commands(self) -> list[PdoMap]:
        return [self.rpdo[command.number] for command in self.layout.commands]

    @property
    def _answers(self) -> list[PdoMap]:
        return [self.tpdo[answer.number] for answer in self.layout.answers]

    # Single objects, at rest

    def read(self, index: int, subindex: int = 0) -> int:
        """Return an object's value; raise `SilentDrive` (no answer) or `WrongDrive` (it refuses)."""
        with self._asked_for(index):
            return int(self._object(index, subindex).raw)

    def write(self, index: int, subindex: int, value: int) -> None:
        """Write a drive's object by SDO; raise `SilentDrive` if it is silent, `WrongDrive` if it refuses."""
        with self._asked_for(index):
            self._object(index, subindex).raw = value

    def order(self, controlword: int) -> None:
        """Write a controlword by SDO without waiting for the answer; raise `can.CanError` if not sent."""
        self.network.send_message(
            0x600 + self.spec.node, struct.pack("<BHBHH", _WRITE_WORD, 0x6040, 0, controlword, 0)
        )

    def _object(self, index: int, subindex: int) -> Any:
        found = self.sdo[index]
        return found if isinstance(found, SdoVariable) else found[subindex]

    @contextmanager
    def _asked_for(self, index: int) -> Iterator[None]:
        try:
            yield
        except NoAnswer:
            raise SilentDrive(self.name, "answer to an SDO", None) from None
        except (SdoCommunicationError, ObjectDictionaryError, struct.error) as error:
            raise WrongDrive(self.name, f"its answer about {index:04X}h", str(error), "by CiA 301") from None

    # On the network

    def start(self) -> None:
        """Let the drive take commands and send answers (NMT start)."""
        self.network.send_message(0, bytes([_START, self.spec.node]))

    def leave(self) -> None:
        """Let the drive take no more commands (NMT enter pre-operational)."""
        self.network.send_message(0, bytes([_PREPARE, self.spec.node]))

    def save_pdos(self) -> None:
        """Map all used PDOs in the drive; raise `SilentDrive` (no answer) or `WrongDrive` (it refuses)."""
        for pdo in (*self._commands, *self._answers):
            with self._asked_for(pdo.com_record.od.index):
                pdo.save() if pdo.com_record[1].writable else save_mapping(pdo)
        for pdo in self._commands:
            # The library would take what a stranger commands for ours.
            self.network.unsubscribe(pdo.cob_id, pdo.on_message)

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> SdoClient:
        """Create an SDO client with these COB-IDs which, unlike canopen's own, needs no receiving thread."""
        client = LineSdoClient(rx_cobid, tx_cobid, self.object_dictionary)
        self.sdo_channels.append(client)
        return client

    # Commanding

    def command(self, target: float) -> None:
        """Set the target of the next period: a speed in [m/s], or a position in [m] or [rad]."""
        self._target = target

    def stand(self, position: float) -> None:
        """Set the commanded and the expected position, in [m] or [rad]; the drive must be at rest there."""
        self._target = position if self.positioned else 0.0
        self._sent = self.units.counts(position) if self.positioned else None
        self.expected.stand_at(position)

    def hold(self) -> None:
        """Stop at the position that the drive's ramps have reached, from the next period on."""
        self._target = self.expected.position if self.positioned else 0.0

    def send(self) -> None:
        """Send the command of this period to an enabled drive."""
        word = State402.CW_OPERATION_ENABLED
        if not self.positioned:
            self._send(word, 0x60FF, self.units.rate(self._target))
            return
        counts = self.units.counts(self._target)
        if self.mode == PROFILE_POSITION and counts != self._sent:
            if self._asks:  # asked twice between two answers, as a stop does: ask again
                self._send(word, 0x607A, self._sent or 0)
            self._plan_speed()
            self._asks = True
        if self._asks:
            word |= NEW_SETPOINT | AT_ONCE
        self._sent = counts
        self._send(word, 0x607A, counts)

    def _plan_speed(self) -> None:
        """Set the profile velocity with which the drive reaches its set-point at the end of the period."""
        way = abs(self._target - self.expected.position)
        self._top = min(self.limits.speed, max(way / self.period, _CREEP * self.limits.speed))
        speed = self.rpdo[2]
        if speed[0x6081].raw != self.units.size(self._top):
            speed[0x6081].raw = self.units.size(self._top)
            speed.transmit()

    def end_handshake(self) -> None:
        """Clear the controlword's bit "new set-point" after the drive's answer, and count set-points that the
        drive has ignored in a row.
        """
        if not self._asks or not self.answered:
            return
        self._asks = False
        self.ignored = 0 if self._status & SETPOINT_TAKEN else self.ignored + 1
        self._send(State402.CW_OPERATION_ENABLED, 0x607A, self._sent or 0)

    def quick_stop(self) -> None:
        """Send a quick stop; the drive's own settings decide how it ends."""
        self._asks = False
        self._send(State402.CW_QUICK_STOP, *self._standing())

    def disable(self) -> None:
        """Disable the drive's torque, unless the robot's file has `stop: hold` for this drive."""
        if self.spec.stop != HOLD_COMMAND:
            self._send(State402.CW_DISABLE_VOLTAGE, *self._standing())

    def _standing(self) -> tuple[int, int]:
        return (0x607A, self._sent or 0) if self.positioned else (0x60FF, 0)

    def _send(self, controlword: int, index: int, target: int) -> None:
        command = self.rpdo[1]
        command[0x6040].raw = controlword
        command[index].raw = target
        command.transmit()

    # Its answers

    def ask(self) -> None:
        """Prepare for a SYNC: from now on, count only answers that arrive after this call."""
        self._fresh.clear()
        self._asked += 1

    def advance(self) -> None:
        """Advance the expected motion, which follows from the axis' last command, by one control period."""
        self.expected.advance(self._target, self._top, self.period)

    @property
    def unanswered(self) -> int:
        """Number of SYNCs sent since the last one to which the drive answered."""
        return self._asked - self._answered

    @property
    def ever_answered(self) -> bool:
        """True if the drive has answered a SYNC."""
        return self._answered > 0

    @property
    def missing(self) -> list[Pdo]:
        """Answers (TPDOs) of the drive to the last SYNC that have not arrived."""
        return [answer for answer in self.layout.answers if answer.objects[0] not in self._fresh]

    @property
    def answered(self) -> bool:
        """True if all of the drive's answers (TPDOs) to the last SYNC have arrived."""
        return len(self._fresh) == len(self.layout.answers)

    def _on_answer(self, pdo: PdoMap) -> None:
        if 8 * len(pdo.data) != pdo.length:
            raise ValueError(f"{len(pdo.data)} bytes")  # counted as malformed
        self._fresh.add(pdo.map[0].index)
        for item in pdo:
            self._reported[item.index] = int(item.raw)
        if self.answered:
            self._answered = self._asked
            self._take_position(self._reported[0x6064])

    def _take_position(self, counts: int) -> None:
        """Accept a measured position in [counts], unless the drive cannot have moved so far."""
        speed = self._reported[0x606C]
        self._jumps.note(speed, self._intended())
        self._reported_travel += speed * self.period
        if self._counts is None:
            self._counts, self._taken = counts, self._asked
            return
        moved = unwrapped(counts, self._counts, self.counted.size)
        most = 2.0 * self.limits.speed * self.period * (2 + self.odd)
        is_too_far = abs(moved) > abs(most * self.units.scale) + 2
        if is_too_far or self._jumps.excess(moved, max(1, self._asked - self._taken)):
            if self.odd == 0:
                self._jump, self._jump_way = moved, self._reported_travel
            self.odd += 1
            return
        self.contradiction += (moved - self._reported_travel) / self.units.scale
        self.odd, self._taken, self._reported_travel = 0, self._asked, 0.0
        self.travel += moved / self.units.scale
        self._counts = counts

    def _intended(self) -> float:
        """Return the speed of this period's command, in [counts/s]."""
        left = (self._target - self.expected.position) / self.period if self.positioned else self._target
        return min(max(left, -self.limits.speed), self.limits.speed) * self.units.scale

    @property
    def jump(self) -> str:
        """Text on the first change of position that was too fast for the axis: its size and likely cause."""
        bits = encoder_bits(self._jump - self._jump_way, 0.1 * abs(self._jump_way) + 2.0)
        size = f"by {self._jump} counts ({self._jump / self.units.scale:.3g} m or rad)"
        if bits is None:
            return size
        needed = "a drive that counts over the whole travel, its range in 607Bh"
        return f"{size}: the encoder wraps, after {2**bits} counts ({bits} bits); needed: {needed}"

    @property
    def position(self) -> float:
        """Measured position, in [m] or [rad]."""
        return self.units.position(0 if self._counts is None else self._counts)

    def place(self, counts: int, velocity: int = 0, torque: int = 0) -> None:
        """Set the measured values that were read by SDO before the first SYNC: the position in [counts], the
        velocity in [counts/s] and the torque in thousandths of the rated torque.
        """
        self._counts, self._taken, self._reported_travel, self.odd = counts, self._asked, 0.0, 0
        self._jumps.forget()
        self._reported |= {0x606C: velocity, 0x6077: torque}

    @property
    def slack(self) -> float:
        """Largest distance of the position beyond its limits at which the drive may be enabled, in [m] or
        [rad].
        """
        return self.limits.window if self.positioned else math.inf

    @property
    def velocity(self) -> float:
        """Velocity of the axis, measured by its drive, in [m/s] or [rad/s]."""
        return self.units.speed(self._reported[0x606C])

    @property
    def torque(self) -> float:
        """Measured torque as a share of the rated torque, positive in the direction in which the position
        grows; 0 if the drive reports none.
        """
        return math.copysign(1.0, self.units.scale) * self._reported.get(0x6077, 0) / 1000.0

    @property
    def tells_torque(self) -> bool:
        """True if the drive has the object torque actual value (6077h), from which its torque can be read."""
        return 0x6077 not in self.left_out

    @property
    def _status(self) -> int:
        return self._reported[0x6041]

    @property
    def drive_state(self) -> str:
        """Name of the drive's CiA 402 state, by the last received statusword."""
        return state_of(self._status)

    @property
    def stands(self) -> bool:
        """True if the drive's last reported velocity is at most 1 % of the axis' top speed."""
        return abs(self.velocity) <= _STANDS * self.limits.speed

    @property
    def mode_display(self) -> int:
        """Mode of operation (6061h) that the drive reported last."""
        return self._reported[0x6061]

    @property
    def fault(self) -> str:
        """Fault that the drive's error code (603Fh) or last emergency message reports, in words; empty
        without a fault.
        """
        active = self.emcy.active[-1].code if self.emcy.active else 0
        return fault_words(self._reported.get(0x603F, 0) or active)


def state_of(statusword: int) -> str:
    """Return the name of the CiA 402 state that a statusword (6041h) encodes, or "unknown ..."."""
    matches = (name for name, (mask, bits) in State402.SW_MASK.items() if statusword & mask == bits)
    return next(matches, f"unknown (statusword {statusword:04X}h)")
