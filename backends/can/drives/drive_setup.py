"""Setting drives up, and reading back what they were set to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress

from canopen.profiles.p402 import OperationMode
from canopen.sdo.exceptions import SdoAbortedError

from handcart.backends.can.bus.errors import Difference, EncoderWraps, ReadBackDiffers, WrongDrive
from handcart.backends.can.bus.pdo_layout import (
    CYCLIC_POSITION,
    CYCLIC_VELOCITY,
    PROFILE_POSITION,
    PROFILE_VELOCITY,
)
from handcart.backends.can.eds.lacks import accepting
from handcart.backends.description.can_spec import CanSpec

from .axis import Axis
from .axis_settings import ObjectValue, mapping, settings
from .position_range import INTEGER32_RANGE, RANGE_LIMIT, narrowed, wrap_inside_travel

_SERVO = 402  # low word of the device type (1000h)
_SUPPORTED = {
    PROFILE_POSITION: "PROFILED POSITION",
    PROFILE_VELOCITY: "PROFILED VELOCITY",
    CYCLIC_POSITION: "CYCLIC SYNCHRONOUS POSITION",
    CYCLIC_VELOCITY: "CYCLIC SYNCHRONOUS VELOCITY",
}


def set_up(axes: Iterable[Axis], spec: CanSpec, period: float) -> None:
    """Write all settings and PDOs, then read everything back; no drive gets torque.

    Args:
        axes: axes on a network.
        spec: the section `can` of the robot's file.
        period: time between two SYNCs [s].

    Raises:
        SilentDrive: a drive does not answer.
        WrongDrive: a node is not a drive that the robot's file needs.
        EncoderWraps: a drive's counts start over inside the travel of its axis.
        ReadBackDiffers: settings read back differently; the error names all of them.
    """
    axes = list(axes)
    for axis in axes:
        axis.leave()
        _check_kind(axis)
        _check_range(axis)
        for setting in settings(axis, spec, period):
            _write(axis, setting)
        _save_pdos(axis)
    differences = [difference for axis in axes for difference in read_back(axis, spec, period)]
    if differences:
        raise ReadBackDiffers(differences)
    look(axes)


def look(axes: Iterable[Axis]) -> None:
    """Read position, velocity and torque of each drive by SDO; raise `CanFault` if a drive cannot be read."""
    for axis in axes:
        readings = [
            0 if value in axis.left_out else _known(axis, ObjectValue(value, 0, 0))
            for value in (0x6064, 0x606C, 0x6077)
        ]
        axis.place(*readings)


def read_back(axis: Axis, spec: CanSpec, period: float) -> Iterator[Difference]:
    """Read all settings of a drive, and yield those that differ from the written ones.

    Args:
        axis: drive on a network.
        spec: the section `can` of the robot's file.
        period: time between two SYNCs, in [s].

    Raises:
        SilentDrive: the drive does not answer.
    """
    for setting in (*settings(axis, spec, period), *mapping(axis)):
        got = _read(axis, setting)
        if got != setting.value:
            name = _name(axis, setting)
            yield Difference(axis.name, setting.index, setting.subindex, name, setting.value, got)


def _check_kind(axis: Axis) -> None:
    kind = _known(axis, ObjectValue(0x1000, 0, 0)) & 0xFFFF
    if kind != _SERVO:
        raise WrongDrive(axis.name, "the device profile (1000h)", str(kind), f"{_SERVO}, drives")
    modes, wanted = _known(axis, ObjectValue(0x6502, 0, 0)), _SUPPORTED[axis.mode]
    if not modes & OperationMode.SUPPORTED[wanted]:
        raise WrongDrive(axis.name, "supported drive modes (6502h)", f"{modes:#x}", wanted.lower())
    for subindex, what, allowed in (
        (1, "vendor-ID (1018h:1)", axis.spec.vendor_id),
        (2, "product code (1018h:2)", axis.spec.product_code),
    ):
        got = _known(axis, ObjectValue(0x1018, subindex, 0)) if allowed is not None else None
        if got != allowed:
            raise WrongDrive(axis.name, what, f"{got:#x}", f"{allowed:#x}, as the robot's file has it")


def _check_range(axis: Axis) -> None:
    """Read the range in which a drive counts; raise `EncoderWraps` if the counts start over inside the
    travel.
    """
    if RANGE_LIMIT in axis.object_dictionary:
        ends = (_read(axis, ObjectValue(RANGE_LIMIT, value, 0)) for value in (1, 2))
        axis.counted = narrowed(INTEGER32_RANGE, *ends)
    wrong = wrap_inside_travel(axis.units, axis.limits, axis.period, axis.counted, axis.positioned)
    if wrong:
        raise EncoderWraps(axis.name, wrong)


def _known(axis: Axis, what: ObjectValue) -> int:
    got = _read(axis, what)
    if isinstance(got, str):
        raise WrongDrive(axis.name, f"{_name(axis, what).lower()} ({what.index:04X}h)", got, "an answer")
    return got


def _write(axis: Axis, setting: ObjectValue) -> None:
    """Write an object; a refused one is reported when it is read back."""
    with suppress(SdoAbortedError, KeyError):
        axis.write(setting.index, setting.subindex, setting.value)


def _save_pdos(axis: Axis) -> None:
    try:
        axis.save_pdos()
    except SdoAbortedError as abort:
        raise WrongDrive(axis.name, "the mapping of its PDOs", f"refused: {abort}", "as planned") from None


def _read(axis: Axis, setting: ObjectValue) -> int | str:
    """Return the value of an object, or the reason, as text, why it cannot be read."""
    try:
        return axis.read(setting.index, setting.subindex)
    except SdoAbortedError as abort:
        return f"refused: {abort}{accepting(setting.index)}"
    except KeyError:
        return f"not in its EDS file{accepting(setting.index)}"


def _name(axis: Axis, setting: ObjectValue) -> str:
    found = axis.object_dictionary.get(setting.index)
    if found is None:
        return "object"
    return str(found.name if setting.subindex == 0 else f"{found.name} {setting.subindex}")
