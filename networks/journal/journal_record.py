"""A line of the journal: how it is sealed, and how a reader checks it."""

from __future__ import annotations

import re
import zlib
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import HandcartError
from handcart.files.printable import printable

_BEGINS, _ENDS = re.compile(rb'\{"q":'), re.compile(rb'"crc":"[0-9a-f]{8}"\}\}')
MAX_JOURNAL = 128 * 2**20
"""[bytes]; no run writes as many."""
FIRST = ""
"""What the first record names as the checksum before it."""


class JournalError(HandcartError):
    """The journal can't be written, or isn't what was written. Exit status 5."""

    def __init__(self, path: Path, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(printable(f"journal {path}: {reason}"))


@dataclass(frozen=True)
class JournalContents:
    """What a journal holds."""

    records: tuple[dict[str, Any], ...]
    torn_at: int | None
    """Offset in [bytes] from which on the tail is no whole record (a crash while writing); None: no such."""
    size: int
    """Of the file, in [bytes]."""


def seal(body: bytes, wall: Mapping[str, Any]) -> tuple[bytes, str]:
    """The line for a record, and its checksum.

    Args:
        body: a JSON object as orjson writes it, checksum of the record before it included.
        wall: what differs between two runs of one seed: `unix_s`, in [s] since 1970, and maybe more; sealed
            by a checksum of its own, outside the chain.
    """
    checksum = blake2b(body, digest_size=12).hexdigest()
    head = b'%b,"h":"%b","wall":%b' % (body[:-1], checksum.encode(), orjson.dumps(wall)[:-1])
    return b'%b,"crc":"%08x"}}\n' % (head, zlib.crc32(head)), checksum


def without_wall(record: dict[str, Any]) -> dict[str, Any]:
    """A record without what the wall clock said: equal in two runs of one seed."""
    return {key: value for key, value in record.items() if key != "wall"}


def read_journal(path: Path) -> JournalContents:
    """All records, each checked byte for byte, and the chain.

    Raises:
        JournalError: it can't be read, is larger than any run's, or a record that others follow isn't what
            was written; a damaged last record can't be told from what a crash leaves, and is only reported.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_JOURNAL + 1)
    except OSError as error:
        raise JournalError(path, f"can't be read: {error.strerror}") from None
    if len(content) > MAX_JOURNAL:
        raise JournalError(path, f"has more than {MAX_JOURNAL} bytes")
    return parse_journal(path, content)


def parse_journal(path: Path, content: bytes) -> JournalContents:
    """As `read_journal`, from the bytes of the file at `path`."""
    records: list[dict[str, Any]] = []
    offset, last = 0, FIRST
    while offset < len(content):
        end = content.find(b"\n", offset) + 1 or len(content)
        record = _checked(content[offset:end])
        number = len(records)
        if record is None or record["q"] != number or record["p"] != last:
            foreign = record is not None and record["q"] == number
            if foreign or _more_than_torn(content[offset:], number):
                raise JournalError(path, _wrong_words(record, number, offset))
            return JournalContents(tuple(records), offset, len(content))
        records.append(record)
        offset, last = end, record["h"]
    return JournalContents(tuple(records), None, len(content))


def _wrong_words(record: dict[str, Any] | None, number: int, offset: int) -> str:
    """What is wrong with what is at an offset, where record `number` should be."""
    wrong = f"record {number} at byte {offset} isn't what was written"
    if record is None:
        return wrong
    if record["q"] == number:
        return f"{wrong}: it doesn't follow the record before it"
    return f"{wrong}: a whole record {record['q']} is there"


def _more_than_torn(tail: bytes, number: int) -> bool:
    """Whether what should begin with a record holds more than a crash leaves of one.

    That is a later record, or a whole one that does not begin the tail: the newline before it may be what is
    damaged, or a record before it may be there twice. Or the record itself, whole, and more than one byte
    after it that somebody wrote. A record that is there twice at the end hides nothing.
    """
    ends = [found.end() for found in _ENDS.finditer(tail)]
    for start in (found.start() for found in _BEGINS.finditer(tail)):
        first = bisect_right(ends, start)
        for end in ends[first : first + 3]:
            record = _checked(tail[start:end] + b"\n")
            if record is not None and (record["q"] > number or start > 0):
                return True
            if record is not None and record["q"] == number:
                return len(tail.rstrip(b"\0")) > end + 1
    return False


def _checked(line: bytes) -> dict[str, Any] | None:
    """The record in a line, if writing it again gives the same bytes."""
    try:
        record: dict[str, Any] = orjson.loads(line)
        body = {key: value for key, value in record.items() if key not in ("h", "wall")}
        wall = {key: value for key, value in record["wall"].items() if key != "crc"}
        again, checksum = seal(orjson.dumps(body), wall)
    except (orjson.JSONDecodeError, KeyError, TypeError, AttributeError):
        return None
    whole = again == line and checksum == record["h"] and {"q", "p", "t", "kind"} <= body.keys()
    return record if whole and type(record["q"]) is int else None
