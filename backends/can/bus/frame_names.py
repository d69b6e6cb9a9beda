"""Names of the nodes on a bus, and of the data in their frames."""

from __future__ import annotations

from collections.abc import Iterator

import canopen
from canopen.pdo import PdoMap

from handcart.files.models.model import FileModel


class PdoField(FileModel):
    """An object of a node's object dictionary that a PDO contains, with the object's name and length in
    [bits].
    """

    index: int
    subindex: int
    name: str
    bits: int
    signed: bool


class PdoNames(FileModel):
    """Names of a PDO and of its fields, for texts about recorded frames."""

    node: int
    what: str
    """Name of the PDO as seen from the node: the node sends TPDO1 and receives RPDO1."""
    fields: tuple[PdoField, ...]


class FrameNames(FileModel):
    """Names of the nodes and PDOs of a bus, as the controlling program has configured them."""

    time: str
    """Kind of the time stamps: `unix`, in [s] since 1970, or `robot`, the simulated robot's time."""
    nodes: dict[int, str]
    """Node ID to name."""
    pdos: dict[int, PdoNames]
    """COB-ID to PDO."""


def names_of(network: canopen.Network, time: str) -> FrameNames:
    """Return the names of a network's nodes and of their enabled PDOs.

    Args:
        network: network with its nodes.
        time: kind of the time stamps: `unix`, in [s] since 1970, or `robot`, the simulated robot's time.
    """
    nodes = {number: str(getattr(node, "name", f"node {number}")) for number, node in network.items()}
    pdos = {}
    for number, node in network.items():
        for what, maps in (("TPDO", node.tpdo), ("RPDO", node.rpdo)):
            for place, map_ in maps.items():
                if map_.enabled and map_.cob_id:
                    fields = tuple(_fields(map_))
                    pdos[map_.cob_id] = PdoNames(node=number, what=f"{what}{place}", fields=fields)
    return FrameNames(time=time, nodes=nodes, pdos=pdos)


def _fields(pdo: PdoMap) -> Iterator[PdoField]:
    for item in pdo.map:
        signed = item.od.data_type in canopen.objectdictionary.datatypes.SIGNED_TYPES
        yield PdoField(
            index=item.index, subindex=item.subindex, name=item.od.name, bits=item.length, signed=signed
        )
