"""Pictures, maps, URDFs and tables as strangers write them: sound ones, damaged at random, seeded."""

from __future__ import annotations

import os
import random
import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.maps.map_file import load_map
from handcart.primitives.field.field import Field
from handcart.primitives.field.target_list import load_targets
from handcart.primitives.seam.seam_file import SEAM_COLUMNS, load_seam
from handcart.robotics.geometry.pose2 import Pose2

from .fuzzed_files import ROBOT_FOLDER, Failure, why_not

SPARSE_BYTES = 1 << 34  # [bytes] of a file that holds nothing
_NUMBERS = (
    b"-1",
    b"0",
    b"1e309",
    b"nan",
    b"2000000000",
    b"99999999999999999999",
    b"1_0",
    b"",
    b"60000",
    b"x",
)
_FIELD = Field(format="handcart-field/1", x_m=(-50.0, 50.0), y_m=(-50.0, 50.0))


@dataclass(frozen=True)
class _Victim:
    """A kind of file: sound content, and what reads it."""

    content: bytes
    read: Callable[[Path], object]


def fuzz_binaries(folder: Path, count: int, seed: int = 0) -> Iterator[Failure | None]:
    """Read that many damaged files in an empty folder; each gives None, or what went wrong, as in `fuzz`."""
    rng, victims = random.Random(seed), _victims()
    robot = (ROBOT_FOLDER / "robot.yaml").read_bytes()
    (folder / "robot.yaml").write_bytes(robot.replace(b"urdf: librarian.urdf", b"urdf: robot.urdf"))
    for name in victims:
        chart = f"image: {name}\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
        (folder / f"{name}.yaml").write_text(chart, encoding="utf-8")
    for number in range(count):
        name = rng.choice(sorted(victims))
        path = folder / name
        content = _put(path, victims[name].content, rng)
        why = why_not(folder, path, victims[name].read)
        path.unlink() if not path.is_dir() else path.rmdir()
        yield Failure(number, name, content, why) if why else None


def _put(path: Path, content: bytes, rng: random.Random) -> bytes:
    """Write content at `path`, damaged, or as a pipe or folder in one of 20 cases; return the content."""
    special = rng.randrange(60)
    if special == 0:
        os.mkfifo(path)
    elif special == 1:
        path.mkdir()
    else:
        content = damaged_bytes(content, rng)
        path.write_bytes(content)
        if special == 2:
            os.truncate(path, SPARSE_BYTES)
    return content if special > 2 else b""


def damaged_bytes(content: bytes, rng: random.Random) -> bytes:
    """Up to four damages: bytes flipped, parts cut, doubled or put elsewhere, numbers and sizes changed."""
    for _ in range(rng.randint(1, 4)):
        content = rng.choice(_DAMAGES)(content, rng)
    return content


def _flipped(content: bytes, rng: random.Random) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.randint(1, 8) if changed else 0):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(content: bytes, rng: random.Random) -> bytes:
    start, end = sorted(rng.randint(0, len(content)) for _ in range(2))
    return content[:start] + content[end:]


def _doubled(content: bytes, rng: random.Random) -> bytes:
    start, end = sorted(rng.randint(0, len(content)) for _ in range(2))
    return content[:end] + content[start:end] * rng.choice((1, 2, 50)) + content[end:]


def _renumbered(content: bytes, rng: random.Random) -> bytes:
    """Replace a number in a text by another one."""
    found = [match.span() for match in re.finditer(rb"-?[0-9][0-9.]*", content[:20_000])]
    if not found:
        return content
    start, end = rng.choice(found)
    return content[:start] + rng.choice(_NUMBERS) + content[end:]


def _resized(content: bytes, rng: random.Random) -> bytes:
    """Return a PNG whose header states another size or pixel format, with a correct checksum."""
    if content[12:16] != b"IHDR" or len(content) < 33:
        return content
    width, height = (rng.choice((0, 1, 5_001, 30_000, 60_000, 2_000_000_000)) for _ in range(2))
    depth, colour = rng.choice((1, 2, 4, 8, 16)), rng.choice((0, 2, 3, 4, 6))
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, rng.randrange(2))
    return content[:12] + header + struct.pack(">I", zlib.crc32(header)) + content[33:]


def _stretched(content: bytes, rng: random.Random) -> bytes:
    """One byte of it, a hundred thousand times."""
    at = rng.randrange(len(content)) if content else 0
    return content[:at] + content[at : at + 1] * 100_000 + content[at:]


_DAMAGES = (_flipped, _cut, _doubled, _renumbered, _resized, _stretched)


def _victims() -> Mapping[str, _Victim]:
    level = (np.arange(64 * 48) % 7 * 42).astype(np.uint8).reshape(48, 64)
    pictures = {f"map.{kind}": _picture(level, kind) for kind in ("png", "ppm", "bmp", "jpeg")}
    octile = "type octile\nheight 48\nwidth 64\nmap\n" + ("." * 30 + "@T" + "GSW." * 8 + "\n") * 48
    maps = {**pictures, "map.map": octile.encode()}
    targets = "name,x_m,y_m\n" + "".join(f"t{n},{n},{n}\n" for n in range(40))
    seam = ",".join(SEAM_COLUMNS) + "\n" + "".join(f"{0.01 * n},1,1,0,0,0\n" for n in range(40))
    return {
        **{name: _Victim(content, _load_chart) for name, content in maps.items()},
        "bare.map": _Victim(octile.encode(), load_map),
        "robot.urdf": _Victim((ROBOT_FOLDER / "librarian.urdf").read_bytes(), _load_urdf),
        "targets.csv": _Victim(targets.encode(), _load_targets),
        "seam.csv": _Victim(seam.encode(), load_seam),
    }


def _picture(level: np.ndarray[tuple[int, ...], np.dtype[np.uint8]], kind: str) -> bytes:
    stream = BytesIO()
    Image.fromarray(level).save(stream, kind)
    return stream.getvalue()


def _load_chart(path: Path) -> object:
    return load_map(path.with_name(f"{path.name}.yaml"))


def _load_targets(path: Path) -> object:
    return load_targets(path, _FIELD, Pose2(0.0, 0.0, 0.0))


def _load_urdf(path: Path) -> object:
    return load_robot(str(path.with_name("robot.yaml")))
