"""Setting a wheel's drive up."""

from __future__ import annotations

from canopen.profiles.p402 import OperationMode
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from .errors import SilentDrive, WrongDrive
from .wheel_drive import WheelDrive

_SERVO = 402  # low word of the device type (1000h)
_VELOCITY = OperationMode.SUPPORTED["PROFILED VELOCITY"]


def set_up(drive: WheelDrive, period: float, acceleration: float, braking: float) -> None:
    """Set mode, period, accelerations and PDOs, and start the node.

    Args:
        drive: on a network.
        period: between two SYNCs, in [s].
        acceleration: of the rim, speeding up and slowing down, in [m/s²].
        braking: in a quick stop, in [m/s²].

    Raises:
        SilentDrive: nothing answers.
        WrongDrive: it is no such drive, or doesn't take a setting.
    """
    drive.nmt.state = "PRE-OPERATIONAL"
    try:
        _check_kind(drive)
        for index, value in (
            (0x1006, round(period * 1e6)),
            (0x6060, OperationMode.PROFILED_VELOCITY),
            (0x60FF, 0),
            (0x6083, drive.counts_of(acceleration)),
            (0x6084, drive.counts_of(acceleration)),
            (0x6085, drive.counts_of(braking)),
        ):
            _set(drive, index, value)
        for pdo in (drive.rpdo[1], drive.tpdo[1], drive.tpdo[2]):
            pdo.save()
    except SdoCommunicationError:
        raise SilentDrive(drive.name, "answer to an SDO", None) from None
    except SdoAbortedError as abort:
        raise WrongDrive(drive.name, "its answer to a setting", str(abort), "no abort") from None
    drive.nmt.state = "OPERATIONAL"


def _check_kind(drive: WheelDrive) -> None:
    kind = drive.sdo[0x1000].raw & 0xFFFF
    if kind != _SERVO:
        raise WrongDrive(drive.name, "the device profile (1000h)", str(kind), f"{_SERVO}, drives")
    modes = drive.sdo[0x6502].raw
    if not modes & _VELOCITY:
        allowed = "profile velocity, bit 2"
        raise WrongDrive(drive.name, "supported drive modes (6502h)", f"{modes:#x}", allowed)


def _set(drive: WheelDrive, index: int, value: int) -> None:
    """Write an object and read it back."""
    drive.sdo[index].raw = value
    got = drive.sdo[index].raw
    if got != value:
        what = f"{drive.object_dictionary[index].name.lower()} ({index:04X}h)"
        raise WrongDrive(drive.name, what, str(got), f"the {value} that was written")
