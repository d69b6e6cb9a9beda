"""Reader of damaged bags, MCAP and SQLite of rosbag2 and rosbag1, up to the damage."""

from __future__ import annotations

import bz2
import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

RECORD_LIMIT = 1 << 28  # [bytes] of one record of MCAP
ROS1_MAGIC = b"#ROSBAG V2.0\n"
CHUNK, CONNECTION, MESSAGE = 5, 7, 2  # rosbag1, the header field `op`


class RawMessage(NamedTuple):
    """Message of a ROS bag as serialized bytes, with its topic, type and time of recording."""

    topic: str
    kind: str
    """Message type in the notation of rosbags, such as `sensor_msgs/msg/Imu`."""
    received: float
    """Time of recording, in [s]."""
    data: bytes
    is_ros1: bool
    """True if it is serialized by ROS 1, False if as CDR."""


def recovered(path: Path) -> Iterator[RawMessage]:
    """Yield the messages of a damaged bag's storage file, from its start until the first damage.

    Raises:
        Exception: the error that the format's reader raises at the damage.
    """
    if path.suffix == ".mcap":
        return _from_mcap(path)
    return _from_sqlite(path) if path.suffix == ".db3" else _from_rosbag1(path)


def _from_mcap(path: Path) -> Iterator[RawMessage]:
    from mcap.records import Channel, Message, Schema
    from mcap.stream_reader import StreamReader

    names, channels = dict[int, str](), dict[int, Channel]()
    with path.open("rb") as stream:
        for record in StreamReader(stream, record_size_limit=RECORD_LIMIT).records:
            if isinstance(record, Schema):
                names[record.id] = record.name
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                kind = names.get(channel.schema_id, "")
                yield RawMessage(channel.topic, kind, 1e-9 * record.log_time, record.data, False)


def _from_sqlite(path: Path) -> Iterator[RawMessage]:
    database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        database.execute("PRAGMA writable_schema=ON")  # also reads a file shorter than its header states
        rows = database.execute("SELECT id, name, type FROM topics")
        topics = {number: (str(name), str(kind)) for number, name, kind in rows}
        for topic, stamp, data in database.execute("SELECT topic_id, timestamp, data FROM messages"):
            if topic in topics:
                yield RawMessage(*topics[topic], 1e-9 * stamp, bytes(data), False)
    finally:
        database.close()


def _from_rosbag1(path: Path) -> Iterator[RawMessage]:
    content = path.read_bytes()
    if not content.startswith(ROS1_MAGIC):
        raise ValueError("no bag of ROS 1: it lacks the first line '#ROSBAG V2.0'")
    topics = dict[int, tuple[str, str]]()
    for header, data in _records(content, len(ROS1_MAGIC), also_cut=True):
        if header.get("op") == bytes([CHUNK]):
            for inner, inside in _records(_decompressed(header, data), 0):
                yield from _message_of(inner, inside, topics)
        else:
            yield from _message_of(header, data, topics)


def _message_of(
    header: dict[str, bytes], data: bytes, topics: dict[int, tuple[str, str]]
) -> Iterator[RawMessage]:
    """Yield the message of a record, or store the topic of a connection record."""
    operation = header.get("op", b"")
    if operation == bytes([CONNECTION]):
        kind = _fields(data)["type"].decode()
        package, _, name = kind.partition("/")
        topics[_number(header["conn"])] = header["topic"].decode(), f"{package}/msg/{name}"
    elif operation == bytes([MESSAGE]) and _number(header["conn"]) in topics:
        seconds, nanoseconds = struct.unpack("<II", header["time"])
        received = seconds + 1e-9 * nanoseconds
        yield RawMessage(*topics[_number(header["conn"])], received, data, True)


def _records(content: bytes, at: int, also_cut: bool = False) -> Iterator[tuple[dict[str, bytes], bytes]]:
    """Yield header and data of each complete record of rosbag1; of a truncated record, its remaining data."""
    while at + 4 <= len(content):
        parts = []
        for is_data in (False, True):
            size = _number(content[at : at + 4])
            at += 4 + size
            if at > len(content) and not (also_cut and is_data):
                return
            parts.append(content[at - size : at])
        yield _fields(parts[0]), parts[1]


def _fields(header: bytes) -> dict[str, bytes]:
    found, at = dict[str, bytes](), 0
    while at + 4 <= len(header):
        size = _number(header[at : at + 4])
        name, _, value = header[at + 4 : at + 4 + size].partition(b"=")
        found[name.decode()] = value
        at += 4 + size
    return found


def _number(field: bytes) -> int:
    return int.from_bytes(field, "little")


def _decompressed(header: dict[str, bytes], data: bytes) -> bytes:
    kind = header.get("compression", b"none")
    if kind == b"bz2":
        return bz2.decompress(data)
    if kind == b"lz4":
        import lz4.frame

        plain: Any = lz4.frame.decompress(data)
        return bytes(plain)
    return data
