"""The objects of a drive."""

from __future__ import annotations

from pathlib import Path

from canopen.objectdictionary import ObjectDictionary, import_od

EDS = Path(__file__).parent / "drive.eds"


def drive_dictionary(node: int) -> ObjectDictionary:
    """Those objects of CiA 402 that are used here, for a node; every velocity drive has them."""
    return import_od(str(EDS), node)
