"""The objects of a drive."""

from __future__ import annotations

from pathlib import Path

from canopen.objectdictionary import ObjectDictionary, import_od

EDS = Path(__file__).parent / "drive.eds"


def drive_dictionary(node: int, eds: Path = EDS) -> ObjectDictionary:
    """The objects of a drive with that node ID; without a file those of CiA 402 that are used here."""
    return import_od(str(eds), node)
