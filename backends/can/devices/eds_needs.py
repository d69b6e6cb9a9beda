"""Objects that a drive's EDS file has to describe, and those that the robot's file must accept as missing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from canopen.objectdictionary import ObjectDictionary, ODVariable

from handcart.backends.can.bus.pdo_layout import layout
from handcart.backends.can.drives.axes import planned_axes
from handcart.backends.can.drives.position_range import described_range, other_type, wrap_inside_travel
from handcart.backends.can.eds.eds_file import missing_objects, read_eds
from handcart.backends.can.eds.lacks import DEVICE_LACKS, lack_of, left_out
from handcart.backends.description.can_spec import AxisSpec, CanSpec, WheelDriveSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import FileError, Finding

from .cyclic_frames import mode_of

_ALWAYS = {
    0x1000: "device type",
    0x1017: "producer heartbeat time",
    0x1018: "identity",
    0x1400: "RPDO 1",
    0x1600: "mapping of RPDO 1",
    0x1800: "TPDO 1",
    0x1801: "TPDO 2",
    0x1A00: "mapping of TPDO 1",
    0x1A01: "mapping of TPDO 2",
    0x6060: "mode of operation",
    0x6083: "profile acceleration",
    0x6502: "supported drive modes",
}


def eds_findings(path: Path, axis: AxisSpec) -> tuple[list[Finding], list[str]]:
    """Return the faults of a drive's EDS file.

    Args:
        path: path of the EDS file, which exists.
        axis: axis whose drive the file describes.

    Returns:
        Faults, each at its place in the EDS file; and messages about functions that the drive lacks, except
        those that the robot's file accepts as missing by `without`.
    """
    try:
        dictionary = read_eds(path, axis.node)
    except FileError as error:
        return list(error.findings), []
    frames = layout(mode_of(axis), left_out(axis))
    mapped = (index for pdo in (*frames.commands, *frames.answers) for index in pdo.objects)
    needed = {index: "for a PDO" for index in mapped if lack_of(index) is None}
    missing = missing_objects(dictionary, _ALWAYS | needed, str(path))
    lacks = list(_unaccepted(dictionary, axis, path.name))
    if wrong := other_type(dictionary):
        lacks.append(f"{path.name}: {wrong}; allowed: 0004h, INTEGER32")
    return missing, lacks


def wrap_findings(robot: RobotFile, spec: CanSpec) -> Iterator[tuple[int, str]]:
    """Yield node ID and message of each drive whose position counts wrap within the travel of its axis.

    The range of the counts is read from the drive's EDS file.
    """
    for _, axis, units, limits in planned_axes(robot, spec):
        if axis.eds is None:
            continue
        counted = described_range(read_eds(robot.folder / axis.eds, axis.node))
        is_positioned = not isinstance(axis, WheelDriveSpec)
        wrong = wrap_inside_travel(units, limits, robot.period_s, counted, is_positioned)
        if wrong:
            yield axis.node, f"by {axis.eds} {wrong}"


def _unaccepted(dictionary: ObjectDictionary, axis: AxisSpec, name: str) -> Iterator[str]:
    for word, lack in DEVICE_LACKS.items():
        if word in axis.without or (lack.positioned and isinstance(axis, WheelDriveSpec)):
            continue
        missing = [f"{index:04X}h" for index in lack.objects if not _described(dictionary, index)]
        if missing:
            wrong = f"{name} describes no {', no '.join(missing)} ({lack.what}): {lack.then}"
            yield f"{wrong}; to accept that: without: [{word}]"


def _described(dictionary: ObjectDictionary, index: int) -> bool:
    """Return True if the object is described; if it is an array, True if its first entry is described."""
    if index not in dictionary:
        return False
    found = dictionary[index]
    return isinstance(found, ODVariable) or 1 in found
