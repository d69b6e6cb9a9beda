"""The drive of one wheel, as the robot commands it."""

from __future__ import annotations

import canopen
from canopen.pdo import PdoMap
from canopen.profiles.p402 import OperationMode, State402
from canopen.sdo.client import SdoClient

from backends.can_spec import WheelDriveSpec

from .drive_dictionary import drive_dictionary
from .errors import DriveNotReady, SilentDrive, TooManyCounts
from .fault_words import fault_words
from .line_sdo_client import LineSdoClient

ENABLED, FAULT = "OPERATION ENABLED", "FAULT"
_AT_ONCE, _ON_SYNC = 255, 1  # transmission types
_COMMAND = (0x6040, 0x60FF)
_ANSWERS = ((0x6041, 0x6064, 0x6061), (0x606C, 0x603F))
_NAMES = {
    0x6041: "statusword and position (6041h, 6064h)",
    0x606C: "velocity and error code (606Ch, 603Fh)",
}
# What leads from a state towards OPERATION ENABLED; FAULT is a person's to reset.
_NEXT = {
    "SWITCH ON DISABLED": State402.CW_SHUTDOWN,
    "READY TO SWITCH ON": State402.CW_SWITCH_ON,
    "SWITCHED ON": State402.CW_OPERATION_ENABLED,
    ENABLED: State402.CW_OPERATION_ENABLED,
    "QUICK STOP ACTIVE": State402.CW_DISABLE_VOLTAGE,
}


class WheelDrive(canopen.RemoteNode):
    """A CiA 402 drive in profile velocity mode.

    Commands go out at once (one PDO: controlword, target velocity); the drive answers each SYNC (two PDOs:
    statusword, position and mode; velocity and error code). Speeds are those of the wheel's rim in [m/s],
    forward positive; counts stay in here.
    """

    def __init__(self, wheel: str, spec: WheelDriveSpec, radius: float, most: float) -> None:
        """A drive that is on no network yet.

        Args:
            wheel: how people call it.
            spec: from the robot's file.
            radius: of the wheel, in [m].
            most: speed of its rim in [m/s], or acceleration in [m/s²], that it is ever told.

        Raises:
            TooManyCounts: that doesn't fit into 32 bits.
        """
        super().__init__(spec.node, drive_dictionary(spec.node))
        self.name = f"the {wheel} drive (node {spec.node})"
        self._counts_per_m = spec.counts_per_m(radius)
        if not abs(most * self._counts_per_m) < 2**31:
            raise TooManyCounts(self.name, abs(most * self._counts_per_m))
        self._fresh: set[int] = set()
        self._asked, self._answered = 0, 0
        self._counts: int | None = None
        self.travel = 0.0
        """How far the wheel has rolled since `rezero`, in [m]."""
        _map(self.rpdo[1], _COMMAND, _AT_ONCE)
        for number, objects in enumerate(_ANSWERS, 1):
            _map(self.tpdo[number], objects, _ON_SYNC)
            self.tpdo[number].rtr_allowed = False
            self.tpdo[number].add_callback(self._on_answer)

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> SdoClient:
        """See the library; the client needs no thread."""
        client = LineSdoClient(rx_cobid, tx_cobid, self.object_dictionary)
        self.sdo_channels.append(client)
        return client

    def counts_of(self, rim: float) -> int:
        """A size, such as an acceleration in [m/s²], of the rim, in counts."""
        return abs(round(rim * self._counts_per_m))

    # Commanding

    def drive(self, speed: float) -> None:
        """Send a speed of the rim, in [m/s], to an enabled drive."""
        self._send(State402.CW_OPERATION_ENABLED, round(speed * self._counts_per_m))

    def quick_stop(self) -> None:
        """Send a quick stop."""
        self._send(State402.CW_QUICK_STOP, 0)

    def disable(self) -> None:
        """Take its torque away and let it go."""
        self._send(State402.CW_DISABLE_VOLTAGE, 0)
        self.nmt.state = "PRE-OPERATIONAL"

    def towards_enabled(self) -> None:
        """Send what leads from its state towards OPERATION ENABLED, standing."""
        self._send(_NEXT.get(self.drive_state, State402.CW_DISABLE_VOLTAGE), 0)

    def _send(self, controlword: int, velocity: int) -> None:
        command = self.rpdo[1]
        command[0x6040].raw = controlword
        command[0x60FF].raw = velocity
        command.transmit()

    # Its answers

    def ask(self) -> None:
        """A SYNC is about to go out: answers before it don't count any more."""
        self._fresh.clear()
        self._asked += 1

    @property
    def answered(self) -> bool:
        """Whether all answers to the last SYNC are there."""
        return len(self._fresh) == len(_ANSWERS)

    def _on_answer(self, pdo: PdoMap) -> None:
        if 8 * len(pdo.data) != pdo.length:
            return
        self._fresh.add(pdo.map[0].index)
        if self.answered:
            self._answered = self._asked
            self._take_position(int(self.tpdo[1][0x6064].raw))

    def _take_position(self, counts: int) -> None:
        if self._counts is not None:
            # The 32 bits go over.
            self.travel += ((counts - self._counts + 2**31) % 2**32 - 2**31) / self._counts_per_m
        self._counts = counts

    def rezero(self) -> None:
        """Count `travel` from here on."""
        self.travel = 0.0

    @property
    def drive_state(self) -> str:
        """By its last statusword, as in CiA 402."""
        status = int(self.tpdo[1][0x6041].raw)
        matches = (name for name, (mask, bits) in State402.SW_MASK.items() if status & mask == bits)
        return next(matches, f"unknown (statusword {status:04X}h)")

    @property
    def stands(self) -> bool:
        """By its last velocity."""
        return int(self.tpdo[2][0x606C].raw) == 0

    def check(self, period: float) -> None:
        """Whether it answered the last SYNC, and is enabled.

        Raises:
            SilentDrive: an answer is missing; `period` of the SYNCs, in [s], tells since when.
            DriveNotReady: it is in another state or mode.
        """
        self.check_answered(period)
        state, mode = self.drive_state, int(self.tpdo[1][0x6061].raw)
        if state != ENABLED:
            raise DriveNotReady(self.name, state, self.fault)
        if mode != OperationMode.PROFILED_VELOCITY:
            raise DriveNotReady(self.name, f"{state}, in the mode {mode} (6061h), not 3", self.fault)

    def check_answered(self, period: float) -> None:
        """Raises `SilentDrive` if an answer to the last SYNC is missing."""
        missing = [_NAMES[each[0]] for each in _ANSWERS if each[0] not in self._fresh]
        if missing:
            age = (self._asked - self._answered) * period if self._answered else None
            raise SilentDrive(self.name, " and no ".join(missing), age)

    @property
    def fault(self) -> str:
        """What it says about its fault, "" if nothing: its error code, else its last emergency message."""
        active = self.emcy.active[-1].code if self.emcy.active else 0
        return fault_words(int(self.tpdo[2][0x603F].raw) or active)


def _map(pdo: PdoMap, objects: tuple[int, ...], transmission: int) -> None:
    pdo.clear()
    for index in objects:
        pdo.add_variable(index)
    pdo.cob_id, pdo.trans_type, pdo.enabled = pdo.predefined_cob_id, transmission, True
