"""The range in which a drive counts positions; beyond its ends the counts start over."""

from __future__ import annotations

import math
from typing import NamedTuple

from canopen.objectdictionary import ObjectDictionary, ODVariable
from canopen.objectdictionary.datatypes import INTEGER32

from .axis_limits import AxisLimits
from .axis_units import AxisUnits

POSITION, RANGE_LIMIT = 0x6064, 0x607B
_PERIODS = 8.0  # of the fastest motion: a shorter range leaves open which way an axis has gone


class PositionRange(NamedTuple):
    """Range of a drive's position counts, from the lowest to the highest count, both included."""

    lowest: int
    highest: int

    @property
    def size(self) -> int:
        """Number of counts after which the position starts over."""
        return self.highest - self.lowest + 1


INTEGER32_RANGE = PositionRange(-(2**31), 2**31 - 1)
"""Range of an INTEGER32, the type of object 6064h in CiA 402."""


def described_range(dictionary: ObjectDictionary) -> PositionRange:
    """Return the range of position counts that an EDS file states, by the limits of its object 6064h (actual
    position) and the default values of its object 607Bh (position range limit).
    """
    found = INTEGER32_RANGE
    position, limit = dictionary.get(POSITION), dictionary.get(RANGE_LIMIT)
    if isinstance(position, ODVariable):
        found = narrowed(found, position.min, position.max)
    if limit is not None and not isinstance(limit, ODVariable) and 1 in limit and 2 in limit:
        found = narrowed(found, limit[1].default, limit[2].default)
    return found


def narrowed(known: PositionRange, lowest: object, highest: object) -> PositionRange:
    """Return the intersection of a range with two limits that a drive or its EDS file states.

    Limits that are not integers, or not in ascending order, are ignored; drives without limits state 0 and 0.

    Args:
        known: range of counts that is known so far.
        lowest: stated lowest count.
        highest: stated highest count.
    """
    if not isinstance(lowest, int) or not isinstance(highest, int) or lowest >= highest:
        return known
    return PositionRange(max(known.lowest, lowest), min(known.highest, highest))


def other_type(dictionary: ObjectDictionary) -> str:
    """Return a message if the data type of the position (6064h) is not INTEGER32; "" otherwise."""
    position = dictionary.get(POSITION)
    if not isinstance(position, ODVariable) or position.data_type == INTEGER32:
        return ""
    bits = len(position)
    wraps = f", which wraps every {2**bits} counts" if 0 < bits < 32 else ""
    return f"the position actual value (6064h) has the data type {position.data_type:04X}h{wraps}"


def wrap_inside_travel(
    units: AxisUnits, limits: AxisLimits, period: float, counted: PositionRange, is_positioned: bool
) -> str:
    """Return a message if a drive's counts wrap inside the travel of its axis; "" if they do not.

    Args:
        units: units of the axis.
        limits: limits of the axis.
        period: control period [s].
        counted: the range in which the drive counts.
        is_positioned: True if the axis is under position control. False for a wheel, whose counts may wrap if
            at full speed it takes more than 8 periods to run through the range.
    """
    size = f"its position (6064h) wraps every {counted.size} counts ({counted.size / abs(units.scale):.3g}"
    if not is_positioned:
        least = _PERIODS * limits.speed * period
        if counted.size / abs(units.scale) > least:
            return ""
        return f"{size} m of the rim); needed: more than {least:.3g} m, {_PERIODS:g} periods at full speed"
    if not (math.isfinite(limits.lower) and math.isfinite(limits.upper)):
        if counted == INTEGER32_RANGE:
            return ""
        return f"{size} m or rad), and the joint turns without end; needed: 32 bits (607Bh)"
    ends = sorted((units.counts(limits.lower), units.counts(limits.upper)))
    if counted.lowest <= ends[0] and ends[1] <= counted.highest:
        return ""
    where = f"{size} m or rad), counting from {counted.lowest} to {counted.highest}"
    return f"{where}: inside the travel, from {ends[0]} to {ends[1]}; needed: a range that holds it (607Bh)"
