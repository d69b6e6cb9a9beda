"""Features that a drive may lack if its robot's file accepts the consequences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from handcart.backends.description.can_spec import AxisSpec, Without


class Lack(NamedTuple):
    """Group of CANopen objects that some drives lack, with its description and the consequence of using a
    drive without it.
    """

    objects: tuple[int, ...]
    what: str
    then: str
    """Consequence of using a drive without these objects."""
    positioned: bool = False
    """True if only drives under position control need these objects."""


DEVICE_LACKS: Mapping[Without, Lack] = {
    "consumer_heartbeat": Lack(
        (0x1016,),
        "consumer heartbeat time",
        "it doesn't notice that this program has died or the cable is off: it continues its last command",
    ),
    "abort_option": Lack(
        (0x6007,),
        "abort connection option",
        "its reaction to a missing heartbeat is its own: it may continue, or lose its torque",
    ),
    "quick_stop_option": Lack(
        (0x605A,), "quick stop option", "whether it keeps its torque behind a quick stop is its own"
    ),
    "quick_stop_ramp": Lack((0x6085,), "quick stop deceleration", "how quickly it stops is its own"),
    "fault_reaction": Lack(
        (0x605E,), "fault reaction option", "whether it brakes or runs out at a fault is its own"
    ),
    "error_code": Lack(
        (0x603F,), "error code", "a fault is reported only by its emergency message, without one in no words"
    ),
    "torque": Lack(
        (0x6077,),
        "torque actual value",
        "no torque is sensed: a joint adds nothing to the force that the hand feels, with none it reads 0; "
        "fingers are assumed to hold something by their width alone",
    ),
    "torque_limit": Lack((0x6072,), "max torque", "it presses with all the torque that it has", True),
    "speed_limit": Lack((0x607F,), "max profile velocity", "nothing but this program limits its speed"),
    "position_limits": Lack(
        (0x607D,), "software position limit", "nothing but this program keeps it within its limits", True
    ),
    "following_error": Lack(
        (0x6065, 0x6066),
        "following error window",
        "only this program notices that it doesn't follow, two periods later",
        True,
    ),
}
"""Lacks by their names in the robot's file."""


def left_out(axis: AxisSpec) -> frozenset[int]:
    """Return the indices of the CANopen objects that an axis' drive lacks, by the key `without` of the
    robot's file.
    """
    return frozenset(index for item in axis.without for index in DEVICE_LACKS[item].objects)


def lack_of(index: int) -> Without | None:
    """Return the feature to which a CANopen object belongs, by its name for `without` in the robot's file.

    None if every drive needs the object.
    """
    return next((word for word, lack in DEVICE_LACKS.items() if index in lack.objects), None)


def accepting(index: int) -> str:
    """Return text, for the end of a message, on how the robot's file can state that a drive lacks an object.

    The text is empty if no drive may lack the object.
    """
    word = lack_of(index)
    return (
        ""
        if word is None
        else f"; if it has none: {DEVICE_LACKS[word].then}; to accept that: without: [{word}]"
    )


def not_watched(axis: AxisSpec) -> list[str]:
    """Return a message for each feature that a drive lacks by the robot's file, with the consequence of the
    lack.
    """
    return [f"without {DEVICE_LACKS[item].what}: {DEVICE_LACKS[item].then}" for item in axis.without]
