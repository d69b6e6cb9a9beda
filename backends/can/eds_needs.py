"""What a drive's EDS file has to describe."""

from __future__ import annotations

from pathlib import Path

from backends.can_spec import AxisSpec
from files.errors import FileError, Finding

from .cyclic_frames import mode_of
from .eds_file import missing_objects, read_eds
from .pdo_layout import layout

_ALWAYS = {
    0x1000: "device type",
    0x1016: "consumer heartbeat time",
    0x1017: "producer heartbeat time",
    0x1018: "identity",
    0x1400: "RPDO 1",
    0x1600: "mapping of RPDO 1",
    0x1800: "TPDO 1",
    0x1801: "TPDO 2",
    0x1A00: "mapping of TPDO 1",
    0x1A01: "mapping of TPDO 2",
    0x6007: "abort connection option",
    0x605A: "quick stop option",
    0x6060: "mode of operation",
    0x6502: "supported drive modes",
}


def eds_findings(path: Path, axis: AxisSpec) -> list[Finding]:
    """What is wrong with a drive's EDS file, each at its place in that file; [] where nothing is.

    Args:
        path: of the file, which exists.
        axis: whose drive it describes.
    """
    try:
        dictionary = read_eds(path, axis.node)
    except FileError as error:
        return list(error.findings)
    frames = layout(mode_of(axis))
    mapped = {index: "for a PDO" for pdo in (*frames.commands, *frames.answers) for index in pdo.objects}
    return missing_objects(dictionary, _ALWAYS | mapped, str(path))
