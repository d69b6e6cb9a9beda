"""Decompression of rosbag2 bags: complete storage files, or single messages (zstd, RFC 8878)."""

from __future__ import annotations

from pathlib import Path
from typing import IO

PACKED_SUFFIXES = (".zstd", ".zst")
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""First bytes of a zstd frame; CDR begins with 00."""
MAX_BYTES = 1 << 36
"""Maximum size of an unpacked file, in bytes."""
PIECE_BYTES = 1 << 20


def is_packed(path: Path) -> bool:
    """Return whether a file is compressed as a whole, by its suffix."""
    return path.suffix in PACKED_SUFFIXES


def unpacked_file(packed: Path, folder: Path) -> tuple[Path, str]:
    """Unpack a compressed file into a folder; from a damaged file, unpack the part before the damage.

    Args:
        packed: file such as `drive_0.db3.zstd`.
        folder: destination of the unpacked file, which is named like `packed` without its last suffix.

    Returns:
        The path of the unpacked file, and a message that describes the damage; empty without damage.
    """
    from zstandard import ZstdError

    target = folder / packed.with_suffix("").name
    with packed.open("rb") as source, target.open("wb") as sink:
        try:
            _copy_unpacked(source, sink)
        except (ZstdError, ValueError) as error:
            return target, f"{packed.name}: damaged ({error}); unpacked up to there"
    return target, ""


def _copy_unpacked(source: IO[bytes], sink: IO[bytes]) -> None:
    """Copy the content of all frames.

    Raises:
        ValueError: the last frame is truncated, or the content has more than `MAX_BYTES`.
        zstandard.ZstdError: a frame is damaged.
    """
    from zstandard import ZstdDecompressor

    frame, size = ZstdDecompressor().decompressobj(), 0
    piece = source.read(PIECE_BYTES)
    while piece:
        plain = frame.decompress(piece)
        size += len(plain)
        if size > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES >> 30} GB")
        sink.write(plain)
        piece = frame.unused_data if frame.eof else b""
        piece = piece or source.read(PIECE_BYTES)
        if frame.eof and piece:
            frame = ZstdDecompressor().decompressobj()
    if not frame.eof:
        raise ValueError("cut off")


def unpacked_message(data: bytes) -> bytes:
    """Return a message's bytes, decompressed if they are a frame of the compressed format zstd.

    Raises:
        zstandard.ZstdError: the frame is damaged.
    """
    if not data.startswith(ZSTD_MAGIC):
        return data
    from zstandard import ZstdDecompressor

    return ZstdDecompressor().decompressobj().decompress(data)
