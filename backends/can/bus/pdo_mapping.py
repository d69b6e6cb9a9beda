"""Mapping of objects into PDOs (CiA 301), in the library's form and in a drive."""

from __future__ import annotations

from canopen.pdo import PdoMap


def save_mapping(pdo: PdoMap) -> None:
    """Write mapping and transmission type of a PDO into its drive; the drive's COB-ID does not change."""
    pdo.com_record[2].raw = pdo.trans_type or 0
    pdo.map_array[0].raw = 0
    for place, item in enumerate(pdo.map, 1):
        pdo.map_array[place].raw = item.index << 16 | item.subindex << 8 | item.length
    pdo.map_array[0].raw = len(pdo.map)
    pdo.subscribe()


def map_objects(pdo: PdoMap, objects: tuple[int, ...], transmission: int) -> None:
    """Replace the objects of a PDO, and enable the PDO with its predefined COB-ID; nothing is sent.

    Args:
        pdo: the PDO, as an object of the library `canopen`.
        objects: indices of the objects, all with sub-index 0.
        transmission: transmission type (CiA 301).
    """
    pdo.clear()
    for index in objects:
        pdo.add_variable(index)
    pdo.cob_id, pdo.trans_type, pdo.enabled = pdo.predefined_cob_id, transmission, True
