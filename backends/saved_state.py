"""Convert plain data to bytes and back: a line with a checksum, JSON, and the arrays as they are in memory.

Such bytes name no class and no function: the reader creates only numbers, texts, lists, mappings and
arrays.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import orjson

from handcart.files.errors import InputError

STATE_FORMAT = "handcart-state/1"
MAX_BYTES = 256 * 2**20
"""Maximum size of a saved state."""
MAX_DEPTH = 48  # levels of lists and mappings
_DTYPES = ("float64", "float32", "int64", "uint8", "bool")
_HEAD = re.compile(rb"handcart-state/(\d{1,3}) ([0-9a-f]{64})\n(?=(\d{1,9})\n)")
_MARKS = {"$array", "$bytes", "$float", "$int"}
_NOT_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


class NotAState(InputError):
    """Error: data are not a saved state, or the state of another kind of object."""


def pack(state: object) -> bytes:
    """Return plain data as bytes, for a checkpoint.

    Plain data are None, bool, int, float, str, bytes and arrays, and lists and mappings of these.

    Raises:
        TypeError: the data contain something else, or a key that is not a text.
    """
    blobs: list[bytes] = []
    text = orjson.dumps(_written(state, blobs))
    body = b"".join((b"%d\n" % len(text), text, *blobs))
    return b"%b %b\n%b" % (STATE_FORMAT.encode(), digest(body).encode(), body)


def unpack(content: bytes) -> Any:
    """Return the plain data that `pack` converted to bytes.

    Raises:
        NotAState: the bytes do not come from `pack`, or are damaged.
    """
    head = _HEAD.match(content[:200])
    if head is None:
        raise NotAState(f"no saved state: it doesn't begin with {STATE_FORMAT}")
    if f"handcart-state/{int(head[1])}" != STATE_FORMAT:
        raise NotAState(f"no saved state of the format {STATE_FORMAT}, but of handcart-state/{int(head[1])}")
    if digest(memoryview(content)[head.end() :]) != head[2].decode():
        raise NotAState("no saved state: it is damaged, its checksum is another one")
    body = memoryview(content)[head.end() + len(head[3]) + 1 :]
    try:
        reader = _Reader(body[int(head[3]) :])
        state = reader.read(orjson.loads(body[: int(head[3])]), MAX_DEPTH)
    except (ValueError, TypeError, KeyError, OverflowError) as error:
        raise NotAState(f"no saved state: {error}") from None
    if reader.taken != len(reader.blobs):
        raise NotAState(f"no saved state: {len(reader.blobs) - reader.taken} bytes follow its arrays")
    return state


def digest(content: bytes | memoryview) -> str:
    """Return the SHA-256 checksum of a content in hexadecimal, by which the content can be identified."""
    return hashlib.sha256(content).hexdigest()


def _written(value: object, blobs: list[bytes]) -> Any:
    match value:
        case None | bool() | str():
            return value
        case int():
            return value if abs(value) < 2**53 else {"$int": str(value)}
        case float():
            return float(value) if math.isfinite(value) else {"$float": str(float(value))}
        case bytes():
            blobs.append(value)
            return {"$bytes": len(value)}
        case np.ndarray():
            if value.dtype.name not in _DTYPES:
                raise TypeError(f"arrays of {value.dtype} can't be kept; allowed: {', '.join(_DTYPES)}")
            blobs.append(value.tobytes())
            return {"$array": value.dtype.name, "shape": list(value.shape)}
        case list() | tuple():
            return [_written(item, blobs) for item in value]
        case Mapping():
            if _MARKS & value.keys() or not all(isinstance(key, str) for key in value):
                raise TypeError(f"keys are words other than {', '.join(sorted(_MARKS))}")
            return {key: _written(item, blobs) for key, item in value.items()}
        case np.generic():
            return _written(value.item(), blobs)
    raise TypeError(f"a {type(value).__name__} can't be kept; allowed: plain data")


class _Reader:
    """Reader that takes the arrays off the end of a saved state, one after the other."""

    def __init__(self, blobs: memoryview) -> None:
        self.blobs, self.taken = blobs, 0

    def read(self, value: Any, depth: int) -> Any:
        """Return the value that `_written` converted to JSON, with its arrays.

        Args:
            value: decoded JSON.
            depth: levels of lists and mappings that may still follow.
        """
        if depth < 0:
            raise ValueError(f"more than {MAX_DEPTH} levels of lists and mappings")
        if isinstance(value, list):
            return [self.read(item, depth - 1) for item in value]
        if not isinstance(value, dict):
            return value
        if not _MARKS & value.keys():
            return {key: self.read(item, depth - 1) for key, item in value.items()}
        return self._marked(value, depth)

    def _marked(self, value: dict[str, Any], depth: int) -> Any:
        match value:
            case {"$int": str(digits)} if re.fullmatch(r"-?\d{1,40}", digits):
                return int(digits)
            case {"$float": str(name)} if name in _NOT_FINITE:
                return _NOT_FINITE[name]
            case {"$bytes": int(size)}:
                return bytes(self._take(size))
            case {"$array": str(dtype), "shape": list(shape)} if dtype in _DTYPES:
                return self._array(np.dtype(dtype), shape)
        raise ValueError("an element is neither a number nor an array")

    def _array(self, dtype: np.dtype[Any], shape: list[Any]) -> Any:
        if len(shape) > 4 or not all(type(item) is int and 0 <= item < 2**31 for item in shape):
            raise ValueError("an array of a shape that none has")
        content = self._take(dtype.itemsize * math.prod(shape))
        if dtype == np.bool_ and not set(bytes(content)) <= {0, 1}:
            raise ValueError("an array of booleans holds other values")
        return np.frombuffer(content, dtype).reshape(shape).copy()

    def _take(self, size: int) -> memoryview:
        if not 0 <= size <= len(self.blobs) - self.taken:
            raise ValueError("it ends within an array")
        self.taken += size
        return self.blobs[self.taken - size : self.taken]
