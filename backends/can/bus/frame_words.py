"""CAN frames in words."""

from __future__ import annotations

import struct
from typing import NamedTuple

import can
from canopen.profiles.p402 import State402

from .fault_words import fault_words
from .frame_names import FrameNames, PdoField, PdoNames

_NMT = {1: "start", 2: "stop", 128: "to pre-operational", 129: "reset node", 130: "reset communication"}
_LIFE = {0: "boot-up", 4: "STOPPED", 5: "OPERATIONAL", 127: "PRE-OPERATIONAL"}
_ORDERS = {
    0x0F: "enable operation",
    0x07: "switch on",
    0x06: "shutdown",
    0x02: "quick stop",
    0x0B: "quick stop",
    0x00: "disable voltage",
}
_TALKING = (0x6040, 0x6041, 0x6060, 0x6061, 0x603F)
"""Objects whose changes are worth reporting: orders, states, modes, errors."""
_ASKS = {0x2F: "write", 0x2B: "write", 0x27: "write", 0x23: "write", 0x40: "read"}
_ANSWERS = {0x60: "written", 0x4F: "is", 0x4B: "is", 0x47: "is", 0x43: "is"}
_LENGTHS = {0x2F: 1, 0x2B: 2, 0x27: 3, 0x23: 4, 0x4F: 1, 0x4B: 2, 0x47: 3, 0x43: 4}
_ABORT = 0x80


class FrameDescription(NamedTuple):
    """Texts that describe a CAN frame, with its node, kind and content, for printed recordings of the bus."""

    who: str
    """Node that sends or receives the frame."""
    what: str
    """Kind of the frame, such as PDO, SDO, EMCY or NMT."""
    words: str
    """Content of the frame in words."""
    state: str | None
    """Part of a repeated frame worth reporting when it changes; None for any other frame."""


class FrameWords:
    """Translator of CAN frames into text with names of nodes and PDOs; an unnamed node appears as its ID."""

    def __init__(self, names: FrameNames) -> None:
        self._names = names

    def describe(self, frame: can.Message) -> FrameDescription:
        """Return a description of a frame, which may be malformed or unknown."""
        if frame.is_error_frame:
            return FrameDescription("bus", "error frame", "", None)
        if frame.is_extended_id or frame.is_fd or frame.is_remote_frame:
            return _unknown(frame)
        data = bytes(frame.data)
        pdo = self._names.pdos.get(frame.arbitration_id)
        if pdo is not None:
            return self._pdo(pdo, data)
        function, node = frame.arbitration_id & 0x780, frame.arbitration_id & 0x7F
        match function, node:
            case 0x000, 0:
                return self._nmt(data)
            case 0x080, 0:
                return FrameDescription("all", "SYNC", "", "")
            case 0x080, _:
                return FrameDescription(self._who(node), "EMCY", _emcy(data), None)
            case 0x580 | 0x600, _:
                return FrameDescription(self._who(node), "SDO", _sdo(data), None)
            case 0x700, _:
                life = _LIFE.get(data[0] & 0x7F, f"state {data[0]}") if data else "without state"
                return FrameDescription(
                    self._who(node), "heartbeat", life, None if life == "boot-up" else life
                )
        return _unknown(frame)

    def _who(self, node: int) -> str:
        return self._names.nodes.get(node, f"node {node}" if node else "all")

    def _nmt(self, data: bytes) -> FrameDescription:
        if len(data) != 2:
            return FrameDescription("all", "NMT", f"of {len(data)} bytes", None)
        return FrameDescription(self._who(data[1]), "NMT", _NMT.get(data[0], f"command {data[0]}"), None)

    def _pdo(self, pdo: PdoNames, data: bytes) -> FrameDescription:
        needed = sum(field.bits for field in pdo.fields) // 8
        if len(data) != needed:
            return FrameDescription(
                self._who(pdo.node), pdo.what, f"{len(data)} bytes; needed: {needed}", f"{len(data)} bytes"
            )
        bits = int.from_bytes(data, "little")
        words, state = [], []
        for field in pdo.fields:
            value = bits & ((1 << field.bits) - 1)
            bits >>= field.bits
            said = _value(field, value)
            words.append(said)
            if field.index in _TALKING:
                state.append(said)
        return FrameDescription(self._who(pdo.node), pdo.what, ", ".join(words), ", ".join(state))


def state_word(statusword: int) -> str:
    """Return the name of the CiA 402 state that a statusword (6041h) encodes, such as "OPERATION ENABLED".

    For a statusword that encodes none, the text contains the word in hexadecimal.
    """
    matches = (name for name, (mask, bits) in State402.SW_MASK.items() if statusword & mask == bits)
    return next(matches, f"statusword {statusword:04X}h")


def order_word(controlword: int) -> str:
    """Return the CiA 402 command that a controlword (6040h) encodes, as text, such as "reset fault"."""
    if controlword & 0x80:
        return "reset fault"
    return _ORDERS.get(controlword & 0x0F, f"controlword {controlword:04X}h")


def _value(field: PdoField, value: int) -> str:
    match field.index:
        case 0x6040:
            return order_word(value)
        case 0x6041:
            return state_word(value)
        case 0x603F:
            return fault_words(value) or "no error"
    if field.signed and value >= 1 << (field.bits - 1):
        value -= 1 << field.bits
    return f"{field.name.lower()} {value}"


def _emcy(data: bytes) -> str:
    if len(data) != 8:
        return f"of {len(data)} bytes"
    code, register = struct.unpack_from("<HB", data)
    return f"{fault_words(code) or 'no error any more'}, register {register:02X}h"


def _sdo(data: bytes) -> str:
    if len(data) != 8:
        return f"of {len(data)} bytes"
    kind, index, subindex, value = struct.unpack("<BHBI", data)
    where = f"{index:04X}h:{subindex}"
    if kind == _ABORT:
        return f"{where} aborted, code {value:08X}h"
    said = _ASKS.get(kind) or _ANSWERS.get(kind)
    if said is None:
        return f"part of a longer answer: {data.hex()}"
    if kind not in _LENGTHS:
        return f"{said} {where}"
    value &= (1 << 8 * _LENGTHS[kind]) - 1
    return f"{said} {where} {value} ({value:X}h)"


def _unknown(frame: can.Message) -> FrameDescription:
    digits = 8 if frame.is_extended_id else 3
    kind = "FD " if frame.is_fd else "remote " if frame.is_remote_frame else ""
    words = f"{kind}{frame.arbitration_id:0{digits}X}h {bytes(frame.data).hex()}".strip()
    return FrameDescription("unknown", "frame", words, words)
