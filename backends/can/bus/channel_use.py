"""Detection of nodes that use a CAN channel already, before this program adds its own."""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Collection

import can

from .open_bus import UDP_MULTICAST

LISTEN_S = 0.4
"""Listening time on a channel, in [s]; a running master sends SYNC in each period."""
ANSWER_S = 0.3
"""Time allowed for nodes to answer a request, in [s]."""
_DEVICE_TYPE = bytes([0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0])  # SDO: read 1000h (CiA 301)
_REQUEST, _NODES = 0x600, 0x7F
_OF_MASTERS = (0x000, 0x080)
_COMMANDS = (0x200, 0x300, 0x400, 0x500, _REQUEST)


def taken_by(
    bus: can.BusABC,
    nodes: Collection[int],
    is_shared: bool,
    clock: Callable[[], float] = time.monotonic,
) -> str:
    """Return a description of a foreign node that already uses the channel of a bus; "" if none is found.

    The function listens before it sends, because a request that is sent at once could stop a running robot on
    this channel. If nothing is heard, it asks for the device type: of the node IDs in `nodes` on a shared
    channel, otherwise of all node IDs.

    Args:
        bus: an open bus without any of our nodes.
        nodes: node IDs of the nodes that will be added to the channel.
        is_shared: True if nodes with other IDs are allowed, as on a wired bus.
        clock: gives the time in [s].
    """
    found = _first_heard(bus, nodes, is_shared, clock() + LISTEN_S, clock)
    if found:
        return found
    asked = sorted(nodes) if is_shared else range(1, 128)
    for node in asked:
        bus.send(can.Message(arbitration_id=_REQUEST + node, data=_DEVICE_TYPE, is_extended_id=False))
    return _first_heard(bus, nodes, is_shared, clock() + ANSWER_S, clock)


def own_channel(name: str) -> str:
    """Return a multicast address for a virtual CAN bus, computed from a robot's name; two different names
    rarely give the same address.
    """
    number = zlib.crc32(name.encode()) % (254 * 254)
    return f"239.74.{1 + number // 254}.{1 + number % 254}"


def other_channel_hint(interface: str, name: str) -> str:
    """Return the end of an error message about a channel that is in use: it says which channels are allowed.

    Args:
        interface: name of the python-can interface.
        name: name of the robot; for `udp_multicast`, a free channel computed from it is given as an example.
    """
    example = f", such as {own_channel(name)}" if interface == UDP_MULTICAST else ""
    return f"allowed: a channel for each robot or bench{example}, here and in the robot's file"


def _first_heard(
    bus: can.BusABC, nodes: Collection[int], is_shared: bool, end: float, clock: Callable[[], float]
) -> str:
    while (left := end - clock()) > 0.0:
        frame = bus.recv(left)
        who = "" if frame is None else _sender(frame, nodes, is_shared)
        if who:
            return who
    return ""


def _sender(frame: can.Message, nodes: Collection[int], is_shared: bool) -> str:
    """Return a description of the sender of a frame, "" if our nodes would not disturb it."""
    if frame.is_error_frame or frame.is_extended_id:
        return ""
    kind, node = frame.arbitration_id & ~_NODES, frame.arbitration_id & _NODES
    if frame.arbitration_id in _OF_MASTERS or (kind in _COMMANDS and node):
        return f"another master ({frame.arbitration_id:03X}h)"
    return f"a node {node} ({frame.arbitration_id:03X}h)" if node in nodes or not is_shared else ""
