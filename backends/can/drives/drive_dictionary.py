"""The objects of a drive."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from canopen.objectdictionary import ObjectDictionary

from handcart.backends.can.eds.eds_file import read_eds

DRIVE_EDS = Path(__file__).parent / "drive.eds"


@cache
def drive_dictionary(node: int, eds: Path = DRIVE_EDS) -> ObjectDictionary:
    """Return the objects of a drive by its EDS file (default: the objects of CiA 402 that are used here).

    Raises:
        FileError: the file cannot be read.
    """
    return read_eds(eds, node)
