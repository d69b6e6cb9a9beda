"""Check of a file with Bullet's saved state, before Bullet reads it.

Bullet's reader trusts a file, sizes and pointers included. A saved state is therefore compared with the
one that the engine itself writes now, its bodies made in the same order: the same chunks, of the same
types and lengths, with pointers to each other in the same pattern. Only numbers may differ, and contacts
may be added or missing. The layout is the file's last chunk, and must equal the engine's own.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.saved_state import NotAState
from handcart.robotics.numerics.arrays import BoolArray, ByteArray

HEADER_BYTES = 12  # bytes: BULLET, size of numbers, of pointers, their order, version
CONTACT_CODE = b"CONT"
MOST_CONTACTS = 20_000
_HEAD = struct.Struct("<4siQii")
_POINTER = 8  # bytes
_COLLIDERS = (b"MBLC", b"COBJ", b"RBDY")
_POINTS = 4  # of a contact, at most
_CHANGES = frozenset(
    {
        "m_activationState1",
        "m_islandTag1",
        "m_companionId",
        "m_uniqueId",
        "m_collisionFilterGroup",
        "m_collisionFilterMask",
    }
)
"""Integers of bodies that change during a run; the last three change as a body meets others.

The collision filters of a saved state are ignored: Bullet does not restore them, and each step sets them
again.
"""
MAX_BULLET_NUMBER = 1.1e30
"""Thresholds that are never reached are 1e30, single or double; no number is larger."""
_SMALL = 1_000_000  # of whole numbers of contacts, at most


class Chunk(NamedTuple):
    """A piece of the file."""

    code: bytes
    address: int
    """Address in the memory of the process that wrote the file; pointers refer to the chunk by it."""
    kind: int
    """Number of its struct in the layout."""
    structs: int
    """Number of structs in it."""
    data: bytes

    @property
    def form(self) -> tuple[bytes, int, int, int]:
        """Code, kind, number of structs and length, which must equal those that the engine writes."""
        return self.code, self.kind, self.structs, len(self.data)


@dataclass(frozen=True)
class _Fields:
    """Offsets and kinds of the values in a struct, in bytes."""

    pointers: tuple[int, ...]
    """Offsets of pointers."""
    doubles: tuple[int, ...]
    floats: tuple[int, ...]
    loose: tuple[int, ...]
    """Offsets of integers of 4 bytes that may differ."""
    fixed: BoolArray
    """(n,) mask of the bytes that must be the same."""
    count: int | None
    """Offset of the number of contact points, in a contact."""


def check_state(kept: bytes, now: bytes) -> None:
    """See that a kept state is one of the world whose state is `now`, so that Bullet may read it.

    Raises:
        NotAState: it is another world's, or no such file.
    """
    theirs, ours = _chunks(kept), _chunks(now)
    if (
        kept[:HEADER_BYTES] != now[:HEADER_BYTES]
        or theirs[-1].form != ours[-1].form
        or theirs[-1].data != ours[-1].data
    ):
        raise NotAState("no saved state: the engine that wrote it is of another version")
    layout = _layout(ours[-1].data)
    bodies, others = _without_contacts(theirs), _without_contacts(ours)
    if [each.form for each in bodies] != [each.form for each in others]:
        raise NotAState("no saved state: the engine's world has other bodies")
    at, where = _places(bodies), _places(others)
    alike: dict[int, list[tuple[Chunk, Chunk]]] = {}
    for mine, own in zip(bodies[:-1], others[:-1], strict=True):
        alike.setdefault(mine.kind, []).append((mine, own))
    for kind, pairs in alike.items():
        _compare(kind, pairs, layout, at, where)
    contacts = [each for each in theirs if each.code == CONTACT_CODE]
    if len({each.form for each in (*contacts, *ours) if each.code == CONTACT_CODE}) > 1:
        raise NotAState("no saved state: a contact of another form")
    if contacts:
        _check_contacts(contacts, layout, [each.address for each in bodies if each.code in _COLLIDERS])


def _chunks(content: bytes) -> list[Chunk]:
    found, offset = [], HEADER_BYTES
    while offset < len(content):
        if offset + _HEAD.size > len(content):
            raise NotAState("no saved state: the engine's part ends within a chunk")
        code, length, address, kind, count = _HEAD.unpack_from(content, offset)
        offset += _HEAD.size
        if length < 0 or offset + length > len(content):
            raise NotAState("no saved state: the engine's part ends within a chunk")
        found.append(Chunk(code, address, kind, count, content[offset : offset + length]))
        offset += length
    if not found:
        raise NotAState("no saved state: the engine's part is empty")
    return found


def _without_contacts(chunks: Sequence[Chunk]) -> list[Chunk]:
    return [each for each in chunks if each.code != CONTACT_CODE]


def _places(chunks: Sequence[Chunk]) -> dict[int, int]:
    """Return the number of each chunk by its address."""
    places = {each.address: number for number, each in enumerate(chunks)}
    if len(places) != len(chunks):
        raise NotAState("no saved state: two chunks of the engine's part are at one address")
    return places


def _compare(
    kind: int,
    pairs: Sequence[tuple[Chunk, Chunk]],
    layout: Sequence[_Fields],
    at: Mapping[int, int],
    where: Mapping[int, int],
) -> None:
    """Chunks of one kind, each with the engine's own."""
    fields = layout[kind] if 0 <= kind < len(layout) else None
    if fields is None or any(len(mine.data) != mine.structs * len(fields.fixed) for mine, _ in pairs):
        if any(mine.data != own.data for mine, own in pairs):
            raise NotAState("no saved state: a chunk of no known form")
        return
    a, b = (_rows([pair[which] for pair in pairs], fields) for which in (0, 1))
    if ((a != b) & fields.fixed).any():
        raise NotAState("no saved state: a body of the engine's world is another one")
    _check_numbers(a, fields)
    for offset in fields.pointers:
        theirs, ours = _read(a, offset, np.uint64).tolist(), _read(b, offset, np.uint64).tolist()
        # What leads to no chunk Bullet leaves as it is: it must be what the engine itself writes.
        if [at.get(each, -1 - each) for each in theirs] != [where.get(each, -1 - each) for each in ours]:
            raise NotAState("no saved state: the engine's part points elsewhere")


def _check_contacts(contacts: Sequence[Chunk], layout: Sequence[_Fields], colliders: Sequence[int]) -> None:
    kind, count = contacts[0].kind, contacts[0].structs
    fields = layout[kind] if 0 <= kind < len(layout) else None
    if fields is None or fields.count is None or count != 1 or len(contacts[0].data) != len(fields.fixed):
        raise NotAState("no saved state: a contact of another form")
    rows = _rows(contacts, fields)
    _check_numbers(rows, fields)
    for offset in fields.pointers:
        if not set(_read(rows, offset, np.uint64).tolist()) <= set(colliders):
            raise NotAState("no saved state: a contact of a body that isn't there")
    points = _read(rows, fields.count, np.int32)
    if len(rows) > MOST_CONTACTS or not ((points >= 0) & (points <= _POINTS)).all():
        raise NotAState(f"no saved state: a contact of more than {_POINTS} points, or too many of them")


def _rows(chunks: Sequence[Chunk], fields: _Fields) -> ByteArray:
    """Return (n, bytes) of all structs in these chunks."""
    return np.frombuffer(b"".join(each.data for each in chunks), np.uint8).reshape(-1, len(fields.fixed))


def _check_numbers(rows: ByteArray, fields: _Fields) -> None:
    for offsets, dtype in ((fields.doubles, np.float64), (fields.floats, np.float32)):
        if offsets:
            values = np.stack([_read(rows, offset, dtype) for offset in offsets])
            if not (np.abs(values) <= MAX_BULLET_NUMBER).all():
                raise NotAState("no saved state: a number of the engine's world is invalid")
    for offset in fields.loose:
        if (np.abs(_read(rows, offset, np.int32).astype(np.int64)) > _SMALL).any():
            raise NotAState("no saved state: a number of the engine's world is beyond all sense")


def _read(rows: ByteArray, offset: int, dtype: type) -> NDArray[Any]:
    size = np.dtype(dtype).itemsize
    return np.ascontiguousarray(rows[:, offset : offset + size]).view(dtype)[:, 0]


# The layout


@cache
def _layout(content: bytes) -> tuple[_Fields, ...]:
    """Return the fields of each struct, as named by the file's layout."""
    names, types, lengths, structs = _tables(content)
    members = {types[kind]: rows for kind, rows in structs}

    def alignment(name: str, inner: str) -> int:
        if name.startswith("*"):
            return _POINTER
        if inner in members:
            return max(alignment(names[n], types[t]) for t, n in members[inner])
        return max(1, min(8, lengths[inner]))

    def flat(kind: str, start: int) -> tuple[list[tuple[str, str, int]], int]:
        """Type, name and offset of each plain value in a struct, and where it ends: as compilers lay it out,
        for Bullet's contacts are not padded by hand.
        """
        found, begun, widest = [], start, 1
        for type_number, name_number in members[kind]:
            name, inner = names[name_number], types[type_number]
            wide = alignment(name, inner)
            start, widest = _aligned(start - begun, wide) + begun, max(widest, wide)
            for _ in range(int(np.prod([int(each) for each in re.findall(r"\[(\d+)\]", name)]))):
                if inner in members and not name.startswith("*"):
                    more, start = flat(inner, start)
                    found += more
                else:
                    found.append(("*" if name.startswith("*") else inner, name.split("[")[0], start))
                    start += _POINTER if name.startswith("*") else lengths[inner]
        return found, _aligned(start - begun, widest) + begun

    return tuple(_fields(*flat(types[kind], 0), "Manifold" in types[kind]) for kind, _ in structs)


def _fields(values: Sequence[tuple[str, str, int]], size: int, contact: bool) -> _Fields:
    by_type: dict[str, list[int]] = {"*": [], "double": [], "float": []}
    loose, fixed, count = [], np.ones(size, np.bool_), None
    for kind, name, offset in values:
        if kind in by_type:
            by_type[kind].append(offset)
            fixed[offset : offset + (4 if kind == "float" else 8)] = False
        elif kind == "int" and (contact or name in _CHANGES):
            loose.append(offset)
            fixed[offset : offset + 4] = False
        if contact and name == "m_numCachedPoints":
            count = offset
    pointers, doubles, floats = (tuple(by_type[kind]) for kind in ("*", "double", "float"))
    return _Fields(pointers, doubles, floats, tuple(loose), fixed, count)


_Tables = tuple[list[str], list[str], dict[str, int], list[tuple[int, list[tuple[int, int]]]]]


def _tables(content: bytes) -> _Tables:
    """Names, types, their lengths, and the structs: numbers of the type, of each member's type and name."""
    at = len(b"SDNANAME")
    names, at = _words(content, at)
    types, at = _words(content, _aligned(at) + 4)
    at = _aligned(at) + 4
    lengths = dict(zip(types, struct.unpack_from(f"<{len(types)}h", content, at), strict=True))
    at = _aligned(at + 2 * len(types)) + 4
    (number,) = struct.unpack_from("<i", content, at)
    structs, at = [], at + 4
    for _ in range(number):
        kind, members = struct.unpack_from("<hh", content, at)
        rows = [struct.unpack_from("<hh", content, at + 4 + 4 * each) for each in range(members)]
        structs.append((kind, [(int(a), int(b)) for a, b in rows]))
        at += 4 + 4 * members
    return names, types, lengths, structs


def _words(content: bytes, at: int) -> tuple[list[str], int]:
    (number,) = struct.unpack_from("<i", content, at)
    words, at = [], at + 4
    for _ in range(number):
        end = content.index(b"\0", at)
        words.append(content[at:end].decode())
        at = end + 1
    return words, at


def _aligned(at: int, to: int = 4) -> int:
    return (at + to - 1) // to * to
