"""A line of the journal: how it is sealed, and how a reader checks it."""

from __future__ import annotations

import re
import zlib
from bisect import bisect_right
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import HandcartError
from handcart.files.printable import printable

_BEGINS, _ENDS = re.compile(rb'\{"q":'), re.compile(rb'"crc":"[0-9a-f]{8}"\}\}')
MAX_JOURNAL = 128 * 2**20
"""Maximum size of a journal, in [bytes]; no run writes as many."""
_HASH = blake2b(digest_size=12)
"""Hash of nothing; a copy of it is made faster than a new one."""
FIRST_CHECKSUM = ""
"""Checksum that the first record names as that of the record before it."""


class JournalError(HandcartError):
    """Error of a journal that cannot be written, or whose content was changed. Exit status 5."""

    def __init__(self, path: Path, reason: str) -> None:
        self.path = path
        self.reason = reason
        super().__init__(printable(f"journal {path}: {reason}"))


@dataclass(frozen=True)
class JournalContents:
    """Records of a journal's file, with its size and the place of an incomplete last record."""

    records: tuple[dict[str, Any], ...]
    torn_at: int | None
    """Offset of an incomplete last record (a crash while writing), in [bytes]; None: all are complete."""
    size: int
    """Size of the file, in [bytes]."""


def seal(body: bytes, wall: bytes) -> tuple[bytes, str]:
    """Return the line for a record, and its checksum.

    Args:
        body: a JSON object as orjson writes it, including the checksum of the record before it.
        wall: a JSON object as orjson writes it, without its last brace. Its fields differ between two runs of
            one seed, such as `unix_s`, in [s] since 1970. They have a checksum of their own, which the next
            record does not contain.
    """
    digest = _HASH.copy()
    digest.update(body)
    checksum = digest.hexdigest()
    head = b"".join((body[:-1], b',"h":"', checksum.encode(), b'","wall":', wall))
    return b'%b,"crc":"%08x"}}\n' % (head, zlib.crc32(head)), checksum


def read_journal(path: Path) -> JournalContents:
    """Read all records of a journal, and check their checksums.

    A damaged last record looks like a crash while writing; it is reported as `torn_at` without an error.

    Raises:
        JournalError: the file cannot be read or is larger than any run's, or a record before the last one was
            changed.
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
    """Parse the bytes of a journal, and check the checksums of its records.

    A damaged last record looks like a crash while writing; it is reported as `torn_at` without an error.

    Args:
        path: the journal, for messages.
        content: bytes of the file.

    Raises:
        JournalError: a record before the last one was changed.
    """
    records: list[dict[str, Any]] = []
    offset, last = 0, FIRST_CHECKSUM
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
    """Return the fault of the bytes at an offset, where record `number` should be."""
    wrong = f"record {number} at byte {offset} isn't what was written"
    if record is None:
        return wrong
    if record["q"] == number:
        return f"{wrong}: it doesn't follow the record before it"
    return f"{wrong}: a whole record {record['q']} is there"


def _more_than_torn(tail: bytes, number: int) -> bool:
    """Return whether a damaged tail holds more than a crash leaves of one record.

    The tail holds more if it contains a later record; a complete record that is not at its begin (the
    newline before may be damaged, or an earlier record repeated); or the complete record `number` and
    more than one byte after it. A last record that is repeated hides nothing.
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
    """Return the record in a line, if writing it again gives the same bytes."""
    try:
        record: dict[str, Any] = orjson.loads(line)
        body = {key: value for key, value in record.items() if key not in ("h", "wall")}
        wall = {key: value for key, value in record["wall"].items() if key != "crc"}
        again, checksum = seal(orjson.dumps(body), orjson.dumps(wall)[:-1])
    except (orjson.JSONDecodeError, KeyError, TypeError, AttributeError):
        return None
    whole = again == line and checksum == record["h"] and {"q", "p", "t", "kind"} <= body.keys()
    return record if whole and type(record["q"]) is int else None
