"""File of recorded readings: blocks of periods, each packed and compressed; an incomplete end is skipped."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from handcart.backends.saved_state import MAX_BYTES, NotAState, pack, unpack
from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.files.regular_file import open_regular

SENSORS_FILE = "sensors.recorded"
FORMAT_HEADER = b"handcart-sensors/1\n"
BLOCK_PERIODS = 100
"""Periods that are compressed together."""
COMPRESSION_LEVEL = 1
SIZE_BYTES = 8


class NoRecording(InputError):
    """Error for a run whose recorded readings are missing or cannot be read."""

    def __init__(self, folder: Path, wrong: str) -> None:
        needed = "needed: a run made with `handcart run --record-sensors`"
        super().__init__(printable(f"{folder / SENSORS_FILE}: {wrong}; {needed}"))


def write_block(file: IO[bytes], data: Any) -> None:
    """Append plain data to a file as one compressed block, and flush it to the operating system."""
    packed = zlib.compress(pack(data), COMPRESSION_LEVEL)
    file.write(len(packed).to_bytes(SIZE_BYTES, "big") + packed)
    file.flush()


def read_blocks(folder: Path) -> Iterator[Any]:
    """Yield the blocks of data in a run's recording of readings; the first block is the file's header.

    Raises:
        NoRecording: the recording is missing, of another format, or damaged.
    """
    try:
        with open_regular(folder / SENSORS_FILE) as file:
            if file.read(len(FORMAT_HEADER)) != FORMAT_HEADER:
                raise NoRecording(folder, f"it is not of the format {FORMAT_HEADER.decode().strip()}")
            while (head := file.read(SIZE_BYTES)) and len(head) == SIZE_BYTES:
                size = int.from_bytes(head, "big")
                packed = file.read(size) if size <= MAX_BYTES else b""
                if len(packed) < size:
                    return
                yield unpack(_decompressed(packed))
    except OSError as error:
        raise NoRecording(folder, f"it can't be read ({error.strerror})") from None
    except (zlib.error, NotAState) as error:
        raise NoRecording(folder, f"it is damaged ({error})") from None


def _decompressed(packed: bytes) -> bytes:
    whole = zlib.decompressobj()
    content = whole.decompress(packed, MAX_BYTES)
    if not whole.eof:
        raise NotAState(f"a block has more than {MAX_BYTES} bytes")
    return content
