"""Pictures as strangers write them: their size is known before they are unpacked (rows T1, T2)."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from handcart.files.errors import FileError
from handcart.files.picture import MAX_PIXELS, read_grey


def bomb(path: Path, width: int, height: int, rows: int) -> Path:
    """Write a PNG that declares that size and holds `rows` rows of zeros."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        body = kind + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    content = zlib.compress(bytes((width + 1) * rows))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", content) + chunk(b"IEND", b"")
    )
    return path


def error_of(path: Path) -> str:
    with pytest.raises(FileError) as error:
        read_grey(path)
    return str(error.value)


@pytest.mark.parametrize("name", ["a.png", "a.pgm", "a.bmp"])
def test_grey_is_read_as_it_is(tmp_path: Path, name: str) -> None:
    level = np.arange(256, dtype=np.uint8).reshape(8, 32)
    Image.fromarray(level).save(tmp_path / name)
    read = read_grey(tmp_path / name)
    assert np.array_equal(read.level, level)
    assert read.opaque is None


def test_colour_is_greyed_16_bits_are_cut_and_what_is_clear_is_told(tmp_path: Path) -> None:
    colours = np.array([[[255, 255, 255, 255], [0, 0, 0, 255], [255, 0, 0, 0]]], dtype=np.uint8)
    Image.fromarray(colours).save(tmp_path / "a.png")
    read = read_grey(tmp_path / "a.png")
    assert read.level.tolist() == [[255, 0, 76]]
    assert read.opaque is not None
    assert read.opaque.tolist() == [[True, True, False]]
    Image.fromarray(np.array([[0, 205 * 257, 65535]], dtype=np.uint16)).save(tmp_path / "b.png")
    assert read_grey(tmp_path / "b.png").level.tolist() == [[0, 205, 255]]
    (tmp_path / "c.pgm").write_bytes(b"P2\n# map_saver\n3 1\n65535\n0 52685 65535\n")
    assert read_grey(tmp_path / "c.pgm").level.tolist() == [[0, 205, 255]]


@pytest.mark.parametrize("side", [5001, 30_000, 60_000, 2_000_000_000])
def test_a_picture_that_unpacks_to_gigabytes_is_refused(tmp_path: Path, side: int) -> None:
    """T2"""
    words = error_of(bomb(tmp_path / "a.png", side, side, 0 if side > 9999 else 100))
    is_counted = side < 10_000  # Pillow rejects the others before it reports their size
    count = f"{side} x {side} pixels" if is_counted else "far too many pixels"
    assert f"a.png:1:1: the picture has {count}" in words
    assert f"allowed: {MAX_PIXELS} in all" in words


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is not a picture; allowed: PNG, PGM, BMP, JPEG"),
        (b"P5\n2000000000 2000000000\n255\n", "pixels; allowed"),
        (b"P5\n10 10\n255\nabc", "is broken or cut short"),
        (b"P5\n10 -10\n255\nabc", "the picture"),
        (b"P5\n" + b"9" * 5000 + b" 1\n255\n", "the picture"),
        (b"P2\n3 1\n255\n0 1 x\n", "is broken"),
        (b"GIF89a", "is not a picture"),
        (b"BM" + bytes(52), "the picture"),
    ],
)
def test_a_broken_picture_is_told(tmp_path: Path, content: bytes, words: str) -> None:
    (tmp_path / "a.pgm").write_bytes(content)
    assert words in error_of(tmp_path / "a.pgm")


def test_a_pipe_and_a_huge_file_are_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    (tmp_path / "huge.png").touch()
    os.truncate(tmp_path / "huge.png", 10**11)
    assert "is a pipe" in error_of(tmp_path / "pipe.png")
    assert "has 100000000000 bytes" in error_of(tmp_path / "huge.png")
