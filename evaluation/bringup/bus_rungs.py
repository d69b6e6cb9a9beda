"""Steps that use the bus and move nothing."""

from __future__ import annotations

import time
from typing import Any

import canopen
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoError
from typing_extensions import override

from handcart.backends.can.bus.can_line import CanLine
from handcart.backends.can.bus.line_sdo_client import LineSdoClient
from handcart.backends.can.drives.axis_settings import mapping, settings
from handcart.backends.can.drives.drive_dictionary import drive_dictionary
from handcart.backends.can.eds.lacks import not_watched

from .rung import Facts, Rung, RungFailed
from .site import Site

_SERVO = 402  # low word of the device type (1000h)
_SCAN = 1.0  # [s] in which nodes answer


class PlainNode(canopen.RemoteNode):
    """CANopen node without object dictionary, to read objects of a device that has not been identified."""

    def __init__(self, node: int) -> None:
        super().__init__(node, drive_dictionary(node))

    def add_sdo(self, rx_cobid: int, tx_cobid: int) -> SdoClient:
        """Create an SDO client for this node, as canopen's node does, but one that works without a receiving
        thread.
        """
        client: SdoClient = LineSdoClient(rx_cobid, tx_cobid, self.object_dictionary)  # type: ignore[no-untyped-call]
        self.sdo_channels.append(client)
        return client


def read_object(line: CanLine, node: int, index: int, subindex: int = 0) -> int | None:
    """Read an object of a CANopen node by SDO, as an unsigned number; None without an answer.

    Args:
        line: the CAN bus.
        node: ID of the node.
        index: index of the object in the node's object dictionary.
        subindex: subindex of the object.
    """
    if node not in line:
        line.add_node(PlainNode(node))
    try:
        return int.from_bytes(line[node].sdo.upload(index, subindex), "little")
    except (SdoAbortedError, SdoError):
        return None


class InterfaceRung(Rung[Site]):
    """Bring-up step that checks that the CAN interface is up and a drive answers on it."""

    name = "interface"
    summary = "the CAN interface is up, its bit rate is the drives', and one of them answers"
    moves = False

    @override
    def climb(self, site: Site) -> Facts:
        spec = site.spec
        first = spec.left.node
        with site.line() as (line, came):
            begun = time.monotonic()
            kind = read_object(line, first, 0x1000)
            took = time.monotonic() - begun
            errors = sum(frame.is_error_frame for frame in came)
            if kind is None:
                raise RungFailed(_no_answer(first, errors, len(came), spec.bitrate_kbit_s))
            if errors:
                wrong = f"{errors} error frames came with the answer"
                raise RungFailed(f"{wrong}; look at the terminations (120 ohm at both ends) and the shields")
        return {
            "interface": spec.interface,
            "channel": spec.channel,
            "bitrate_kbit_s": spec.bitrate_kbit_s,
            **({} if site.bench else {"answer_ms": round(1e3 * took, 2)}),
        }


def _no_answer(node: int, errors: int, frames: int, bitrate: int) -> str:
    if errors:
        return (
            f"node {node} doesn't answer, and {errors} error frames came: is its bit rate {bitrate} kbit/s?"
        )
    if frames:
        return f"node {node} doesn't answer, others do ({frames} frames): is that its node ID, has it power?"
    return f"nothing came: power, cable and terminations of the bus; node {node}; {bitrate} kbit/s"


class IdentifyRung(Rung[Site]):
    """Bring-up step that checks that the nodes on the CAN bus are exactly those of the robot's file."""

    name = "identify"
    summary = "the nodes on the bus are those of the robot's file, drives all, and no others"
    moves = False

    @override
    def climb(self, site: Site) -> Facts:
        wanted = {axis.node: (name, axis) for name, axis in site.spec.axes()}
        with site.line() as (line, _):
            line.scanner.search()
            line.wait(lambda: False, _SCAN)
            found = sorted(set(line.scanner.nodes))
            missing = [f"{name} (node {node})" for node, (name, _) in wanted.items() if node not in found]
            strangers = [str(node) for node in found if node not in wanted]
            wrong = [f"no answer of {', '.join(missing)}"] if missing else []
            wrong += [f"not in the robot's file: node {', '.join(strangers)}"] if strangers else []
            identities = {}
            for node in found:
                if node in wanted:
                    identities[wanted[node][0]] = facts = _identity(line, node)
                    wrong += _differences(*wanted[node], facts)
        if wrong:
            raise RungFailed("; ".join(wrong))
        return {"nodes": identities}


def _identity(line: CanLine, node: int) -> dict[str, Any]:
    names = {1: "vendor_id", 2: "product_code", 3: "revision", 4: "serial"}
    identity = {name: read_object(line, node, 0x1018, sub) for sub, name in names.items()}
    known = {name: value for name, value in identity.items() if value is not None}
    return {"node": node, "device_type": read_object(line, node, 0x1000), **known}


def _differences(name: str, axis: Any, facts: dict[str, Any]) -> list[str]:
    wrong = []
    kind = facts["device_type"]
    if kind is None or kind & 0xFFFF != _SERVO:
        wrong.append(f"{name} (node {axis.node}) is not a CiA 402 drive: its device type (1000h) is {kind}")
    for key in ("vendor_id", "product_code"):
        expected = getattr(axis, key)
        if expected is not None and facts.get(key) != expected:
            wrong.append(
                f"{name} (node {axis.node}): {key} is {facts.get(key)}, in the robot's file {expected}"
            )
    return wrong


class ReadBackRung(Rung[Site]):
    """Bring-up step that writes all settings of the drives and checks that they are read back as written."""

    name = "read_back"
    summary = "supervision, reactions, limits and mappings are written, and read back as they were written"
    moves = False

    @override
    def climb(self, site: Site) -> Facts:
        accepted = {name: not_watched(axis) for name, axis in site.spec.axes() if axis.without}
        for name, words in accepted.items():
            for word in words:
                site.operator.tell(f"{name}: {word}")
        with site.backend() as backend:  # building it writes and reads back
            read = {
                name: len([*settings(axis, site.spec, site.robot.period_s), *mapping(axis)])
                for name, axis in backend.axes.items()
            }
            reactions = {
                name: {f"{item.index:04X}h:{item.subindex}": item.value for item in _supervision(axis, site)}
                for name, axis in backend.axes.items()
            }
        return {"settings": read, "supervision": reactions, **({"accepted": accepted} if accepted else {})}


def _supervision(axis: Any, site: Site) -> list[Any]:
    indices = (0x1016, 0x1017, 0x1029, 0x6007, 0x605A, 0x605E)
    return [setting for setting in settings(axis, site.spec, site.robot.period_s) if setting.index in indices]
