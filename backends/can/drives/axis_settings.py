"""Settings that a drive needs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from handcart.backends.can.bus.pdo_layout import CYCLIC_POSITION, CYCLIC_VELOCITY, OBJECT_BITS
from handcart.backends.description.can_spec import CanSpec

from .axis import HOLD_COMMAND, Axis
from .position_range import INTEGER32_RANGE

QUICK_STOP_AND_STAY, QUICK_STOP_AND_DISABLE = 6, 2
"""Quick stop option codes (605Ah) that slow down on the quick stop ramp, then stay, or disable."""
_SLOW_DOWN = 2  # fault reaction (605Eh): on the quick stop ramp
_QUICK_STOP = 3  # abort connection option (6007h)
_PRE_OPERATIONAL = 0  # error behaviour (1029h): commands that were queued are not taken any more
_ANY = 0xFFFFFFFF
_IF_THERE = (
    (0x1006, 0),  # only gives the drive the period of SYNC
    (0x1029, 1),  # without it a node becomes PRE-OPERATIONAL (CiA 301)
    (0x1400, 5),  # besides the heartbeat
    (0x6080, 0),  # besides 607Fh
    (0x6084, 0),  # without it a drive slows down as it speeds up
)


@dataclass(frozen=True)
class ObjectValue:
    """CANopen object of a drive, by index and sub-index, and the value to write to it."""

    index: int
    subindex: int
    value: int


def settings(axis: Axis, spec: CanSpec, period: float) -> list[ObjectValue]:
    """Return the objects that configure a drive, each with the value to write, except those of its PDOs.

    Args:
        axis: axis with the drive.
        spec: the section `can` of the robot's file.
        period: time between two SYNCs, in [s].
    """
    planned = [*_communication(spec, period), *_stopping(axis), *_ramps(axis), *_mode(axis, period)]
    wanted = [item for item in planned if item.index not in axis.left_out]
    optional = [item for item in wanted if (item.index, item.subindex) in _IF_THERE]
    return [item for item in wanted if item not in optional or _has(axis, item)]


def mapping(axis: Axis) -> Iterator[ObjectValue]:
    """Yield the drive's objects that configure an axis' PDOs (CiA 301), each with the value that it must
    have.
    """
    for first, mapped, pdos in (
        (0x1400, 0x1600, axis.layout.commands),
        (0x1800, 0x1A00, axis.layout.answers),
    ):
        for pdo in pdos:
            yield ObjectValue(first + pdo.number - 1, 2, pdo.transmission)
            record = mapped + pdo.number - 1
            yield ObjectValue(record, 0, len(pdo.objects))
            for place, index in enumerate(pdo.objects, 1):
                yield ObjectValue(record, place, index << 16 | OBJECT_BITS[index])


def _communication(spec: CanSpec, period: float) -> Iterator[ObjectValue]:
    yield ObjectValue(0x1006, 0, round(period * 1e6))
    yield ObjectValue(0x1016, 1, spec.our_node << 16 | spec.heartbeat_timeout_ms)
    yield ObjectValue(0x1017, 0, spec.heartbeat_ms)
    yield ObjectValue(0x1029, 1, _PRE_OPERATIONAL)
    # Commands may be as old as heartbeats.
    yield ObjectValue(0x1400, 5, max(spec.heartbeat_timeout_ms, math.ceil(3e3 * period)))


def _stopping(axis: Axis) -> Iterator[ObjectValue]:
    stays = axis.spec.stop == HOLD_COMMAND
    yield ObjectValue(0x6007, 0, _QUICK_STOP)
    yield ObjectValue(0x605A, 0, QUICK_STOP_AND_STAY if stays else QUICK_STOP_AND_DISABLE)
    yield ObjectValue(0x605E, 0, _SLOW_DOWN)


def _ramps(axis: Axis) -> Iterator[ObjectValue]:
    units, limits = axis.units, axis.limits
    speed = units.size(limits.speed)
    yield ObjectValue(0x607F, 0, speed + 1)
    yield ObjectValue(0x6080, 0, math.ceil(60.0 * speed / axis.spec.counts_per_rev))
    yield ObjectValue(0x6083, 0, units.size(limits.acceleration))
    yield ObjectValue(0x6084, 0, units.size(limits.acceleration))
    yield ObjectValue(0x6085, 0, units.size(limits.braking))
    if not axis.positioned:
        return
    yield ObjectValue(0x6081, 0, speed)
    yield ObjectValue(0x6072, 0, limits.torque)
    lowest, highest = _ends(axis)
    yield ObjectValue(0x607D, 1, lowest)
    yield ObjectValue(0x607D, 2, highest)
    yield ObjectValue(0x6065, 0, units.size(limits.window) if math.isfinite(limits.window) else _ANY)
    yield ObjectValue(0x6066, 0, axis.spec.following_ms)


def _ends(axis: Axis) -> tuple[int, int]:
    """Return the lowest and highest position of an axis, in [counts]; all counts if it turns without end."""
    units, limits = axis.units, axis.limits
    if not (math.isfinite(limits.lower) and math.isfinite(limits.upper)):
        return INTEGER32_RANGE
    lowest, highest = sorted((units.counts(limits.lower), units.counts(limits.upper)))
    return lowest, highest


def _mode(axis: Axis, period: float) -> Iterator[ObjectValue]:
    yield ObjectValue(0x6060, 0, axis.mode)
    if axis.mode in (CYCLIC_POSITION, CYCLIC_VELOCITY):
        value, index = interpolation_time(period)
        yield ObjectValue(0x60C2, 1, value)
        yield ObjectValue(0x60C2, 2, index)


def interpolation_time(period: float) -> tuple[int, int]:
    """Return a period, given in [s], in the form of object 60C2h: a value and the exponent of a power of
    ten.
    """
    for index in (-3, -4, -5, -2, -6):
        value = period / 10.0**index
        if abs(value - round(value)) < 1e-6 and 1 <= round(value) <= 255:
            return round(value), index
    raise ValueError(f"a period of {period} s doesn't fit into 60C2h; allowed: two and a half digits")


def _has(axis: Axis, setting: ObjectValue) -> bool:
    found = axis.object_dictionary.get(setting.index)
    return found is not None and (setting.subindex == 0 or setting.subindex in found)
