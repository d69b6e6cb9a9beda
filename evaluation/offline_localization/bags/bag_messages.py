"""Reader of bags of all kinds, complete or damaged, that decodes the messages of some types."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from .bag_compression import is_packed, unpacked_file, unpacked_message
from .bag_recovery import RawMessage, recovered

STORAGE_SUFFIXES = (".mcap", ".db3", ".bag")
METADATA_FILE = "metadata.yaml"
ALLOWED_TEXT = "allowed: rosbag2 (SQLite, MCAP; also with .zstd), rosbag1"


class BagError(Exception):
    """Error for a ROS bag that cannot be read; the message gives the reason."""


class BagMessage(NamedTuple):
    """Decoded message of a ROS bag, with its topic, type and time of recording."""

    topic: str
    kind: str
    received: float
    """Time of recording, in [s]."""
    content: Any


class Bag(NamedTuple):
    """Content of a ROS bag: its decoded messages, and what could not be decoded."""

    topics: dict[str, str]
    """Type of each topic, in the bag's order."""
    messages: list[BagMessage]
    """Messages of the requested types, in the order of recording."""
    unreadable: dict[str, int]
    """Number of messages that cannot be decoded, by topic."""
    notes: list[str]
    """Messages about faults of the bag itself."""


def read_bag(path: Path, kinds: Collection[str]) -> Bag:
    """Read all messages of the given types from a ROS bag.

    The messages of a damaged bag, without an index, its end or metadata.yaml, are read from its storage
    files, up to the first damage.

    Args:
        path: a folder of rosbag2, or a .mcap, .db3 or .bag file, optionally compressed (.zstd).
        kinds: message types, such as `sensor_msgs/msg/Imu`.

    Raises:
        BagError: nothing can be read.
    """
    files, notes = _storage_files(path)
    is_whole = path.is_dir() and (path / METADATA_FILE).is_file()
    with TemporaryDirectory() as folder:
        try:
            return _complete([path] if is_whole else _unpacked(files, Path(folder), notes), kinds, notes)
        except Exception as error:  # damaged bytes may raise any error
            notes = notes if is_whole else _storage_files(path)[1]
            return _damaged(
                _unpacked(files, Path(folder), notes),
                kinds,
                notes,
                _first_line(error).replace(f"{folder}/", ""),
            )


def has_bag_suffix(path: Path) -> bool:
    """Return whether a file has the name of a ROS bag's storage file, compressed or not."""
    return (path.with_suffix("") if is_packed(path) else path).suffix in STORAGE_SUFFIXES


def _unpacked(files: list[Path], folder: Path, notes: list[str]) -> list[Path]:
    """Return the storage files, with compressed ones replaced by files unpacked into a folder."""
    found = list[Path]()
    for file in files:
        words = ""
        if is_packed(file):
            file, words = unpacked_file(file, folder)
        found.append(file)
        notes += [words] if words else []
    return found


def _storage_files(path: Path) -> tuple[list[Path], list[str]]:
    """Return the storage files of a bag, and notes about unusual ones.

    Raises:
        BagError: the path is missing, or the folder contains no storage file.
    """
    if not path.exists():
        raise BagError(f"no such file or folder; {ALLOWED_TEXT}")
    if not path.is_dir():
        return [path], []
    files = sorted(item for item in path.iterdir() if has_bag_suffix(item) and item.is_file())
    files = [file for file in files if not is_packed(file) or file.with_suffix("") not in files]
    if not files:
        raise BagError(f"no .mcap, .db3 or .bag file in the folder, nor one with .zstd; {ALLOWED_TEXT}")
    if (path / METADATA_FILE).is_file():
        return files, []
    return files, [f"the folder has no {METADATA_FILE}: its {len(files)} storage files are read as they are"]


def _complete(paths: list[Path], kinds: Collection[str], notes: list[str]) -> Bag:
    """Read a bag by its index."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    messages, unreadable = list[BagMessage](), Counter[str]()
    with AnyReader(paths, default_typestore=get_typestore(Stores.LATEST)) as reader:
        topics = {item.topic: item.msgtype for item in reader.connections}
        chosen = [item for item in reader.connections if item.msgtype in kinds]
        for connection, nanoseconds, raw in reader.messages(chosen) if chosen else ():
            kind = connection.msgtype
            try:
                content = reader.deserialize(unpacked_message(raw), kind)
            except Exception:  # see `read_bag`
                unreadable[connection.topic] += 1
                continue
            messages.append(BagMessage(connection.topic, kind, 1e-9 * nanoseconds, content))
    return Bag(topics, messages, dict(unreadable), notes)


def _damaged(files: list[Path], kinds: Collection[str], notes: list[str], why: str) -> Bag:
    """Read a bag from its storage files, each up to its first damage.

    Raises:
        BagError: no message can be read.
    """
    topics, messages, unreadable = dict[str, str](), list[BagMessage](), Counter[str]()
    notes = [*notes, f"the bag is damaged or cut off ({why}): it is read up to there"]
    for raw in (raw for file in files for raw in _until_damage(file, notes)):
        topics.setdefault(raw.topic, raw.kind)
        if raw.kind not in kinds:
            continue
        try:
            content = _decoded(raw)
        except Exception:  # see `read_bag`
            unreadable[raw.topic] += 1
            continue
        messages.append(BagMessage(raw.topic, raw.kind, raw.received, content))
    if not topics:
        raise BagError(f"no bag that can be read: {why}; {ALLOWED_TEXT}")
    messages.sort(key=lambda message: message.received)
    return Bag(topics, messages, dict(unreadable), notes)


def _until_damage(file: Path, notes: list[str]) -> Iterator[RawMessage]:
    count = 0
    try:
        for raw in recovered(file):
            count += 1
            yield raw
    except Exception as error:  # see `read_bag`
        notes.append(f"{file.name}: {count} messages are read, then {_first_line(error)}")


def _decoded(raw: RawMessage) -> Any:
    store = _typestore(raw.is_ros1)
    decode = store.deserialize_ros1 if raw.is_ros1 else store.deserialize_cdr
    return decode(unpacked_message(raw.data), raw.kind)


@cache
def _typestore(is_ros1: bool) -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.LATEST)


def _first_line(error: Exception) -> str:
    lines = str(error).splitlines()
    return (lines[0] if lines else type(error).__name__).rstrip(".")
