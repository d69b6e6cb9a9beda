"""Recorder of a bench's topics into a bag of rosbag2, written by the library `rosbags`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np

from handcart.backends.ros2.bench.local_air import LocalAir, LocalLink

Spoil = Callable[[str, Any, float], Any]
"""Takes a topic, a message of rosbags and the time of the bench in [s]; returns the message to be written."""


class BagRecorder:
    """Writes all that is published in this process; use as a context manager, `record` each period."""

    def __init__(
        self, path: Path, air: LocalAir, topics: Mapping[str, str], storage: str, spoil: Spoil | None = None
    ) -> None:
        """Open a bag.

        Args:
            path: a folder that doesn't exist yet.
            air: topics of the bench.
            topics: type of the messages of each topic to record.
            storage: SQLITE3 or MCAP.
            spoil: changes messages before they are written; None: they are as they were sent.
        """
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        self._store: Any = get_typestore(Stores.ROS2_JAZZY)
        self._air, self._spoil = air, spoil or (lambda topic, message, now: message)
        self._writer: Any = Writer(path, version=9, storage_plugin=StoragePlugin[storage])
        self._link, self._topics = LocalLink(air, "recorder"), topics

    def __enter__(self) -> Self:
        self._writer.open()
        for topic, kind in self._topics.items():
            full = kind.replace("/", "/msg/")
            end = self._writer.add_connection(f"/{topic}", full, typestore=self._store)
            self._link.subscribe(kind, topic, self._taker(topic, full, end))
        return self

    def __exit__(self, *_: object) -> None:
        self._link.close()
        self._writer.close()

    def record(self) -> None:
        """Write what was published since the last call."""
        self._link.receive()

    def _taker(self, topic: str, kind: str, end: Any) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            made = self._spoil(topic, self._made(kind, message), self._air.time)
            raw = self._store.serialize_cdr(made, kind)
            self._writer.write(end, round(1e9 * self._air.time), bytes(raw))

        return take

    def _made(self, kind: str, message: Any) -> Any:
        """Return a message of rosbags with the fields of one of this process; others are zero."""
        fields = {
            name: self._value(form, getattr(message, name, None))
            for name, form in self._store.fielddefs[kind][1]
        }
        return self._store.types[kind](**fields)

    def _value(self, form: Any, value: Any) -> Any:
        from rosbags.interfaces import Nodetype

        node, words = form
        if node is Nodetype.NAME:
            return self._made(words, value)
        if node is Nodetype.BASE:
            return _base(words[0], value)
        (inner, name), size = words
        if inner is Nodetype.NAME:
            return [self._made(name, item) for item in value or ()]
        if name[0] == "string":
            return [str(item) for item in value or ()]
        if value is None:
            return np.zeros(size, np.dtype(name[0]))
        if name[0] == "uint8":
            return np.frombuffer(bytes(value), np.uint8)
        return np.asarray(value, np.dtype(name[0]))


def _base(kind: str, value: Any) -> Any:
    if kind == "string":
        return str(value or "")
    if kind == "bool":
        return bool(value)
    return float(value or 0.0) if kind.startswith("float") else int(value or 0)
