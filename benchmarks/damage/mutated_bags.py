"""Play damaged ROS bags: `python -m benchmarks.damage.mutated_bags [--bags N] [--seed N]`

Each is a small bag (SQLite, MCAP, ROS 1) with one thing broken: cut off, bits flipped, blocks of zeros,
metadata gone or wrong, types exchanged, values and stamps of nonsense. `handcart localize` has to play it or
to refuse it in words: no traceback, no status 5. "Silent" counts those that were played without a note and
end further off the truth than five claimed sigma.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import random
import shutil
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.progress import track

from benchmarks.damage.bag_files import START_TIME_S, TOPIC_TYPES, BagDrive, Stamp, small_drive, write_bag

STORAGE_NAMES = ("SQLITE3", "MCAP", "ROS1")
MAX_SIGMAS = 5.0
ALLOWED_STATUSES = (0, 2)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bags", type=int, default=200, help="default 200")
    parser.add_argument("--seed", type=int, default=0, help="of the first bag (default 0)")
    parser.add_argument("--show", action="store_true", help="print what was broken and what was said of it")
    chosen = parser.parse_args()
    statuses, silent, failures = Counter[int](), 0, list[str]()
    with tempfile.TemporaryDirectory() as folder:
        for seed in track(range(chosen.seed, chosen.seed + chosen.bags), "bags"):
            path, words = mutated_bag(Path(folder) / str(seed), seed)
            status, out, err = played(path)
            statuses[status] += 1
            wrong = is_silent(status, out)
            silent += wrong
            if status not in ALLOWED_STATUSES or "Traceback" in err or wrong:
                failures.append(f"seed {seed}: {words}: status {status}, {err.strip().splitlines()[-1:]}")
            if chosen.show:
                print(f"seed {seed}: {words}: status {status}: {(err or out).strip().splitlines()[:1]}")
            shutil.rmtree(Path(folder) / str(seed), ignore_errors=True)
    print("\n".join(failures))
    counts = ", ".join(f"status {status}: {count}" for status, count in sorted(statuses.items()))
    print(f"{chosen.bags} mutated bags: {counts}; status 5: {statuses[5]}; silent: {silent}")
    sys.exit(1 if failures else 0)


def mutated_bag(folder: Path, seed: int) -> tuple[Path, str]:
    """Write a bag with one thing broken, and say what; the same for the same seed."""
    rng = random.Random(seed)
    folder.mkdir()
    storage = rng.choice(STORAGE_NAMES)
    path = folder / ("drive.bag" if storage == "ROS1" else "drive")
    if rng.random() < 0.4:
        drive, stamp, topics, words = _content_fault(rng)
        return write_bag(path, drive, storage, stamp, topics), f"{storage}, {words}"
    write_bag(path, small_drive(duration=30.0), storage)
    file = path if storage == "ROS1" else next(item for item in path.iterdir() if item.suffix != ".yaml")
    if storage != "ROS1" and rng.random() < 0.3:
        return path, f"{storage}, {_break_metadata(path / 'metadata.yaml', rng)}"
    words = rng.choice(_BYTES)(file, rng)
    target = file if rng.random() < 0.3 else path
    if rng.random() < 0.2 and storage != "ROS1":
        (path / "metadata.yaml").unlink()
        words += ", metadata.yaml is gone"
    return target, f"{storage}, {words}"


def played(path: Path) -> tuple[int, str, str]:
    """Return status, stdout and stderr of `handcart localize`."""
    from handcart.tools.main import main as handcart

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            handcart(["localize", str(path), "--reference", "/truth", "--json"])
        except SystemExit as end:
            return int(end.code or 0), out.getvalue(), err.getvalue()
    return 0, out.getvalue(), err.getvalue()


def is_silent(status: int, out: str) -> bool:
    """Return whether a bag was played without a note, and the claims are far from true."""
    if status:
        return False
    found = json.loads(out)
    return not found["notes"] and found.get("nees", 0.0) > MAX_SIGMAS**2


def _content_fault(rng: random.Random) -> tuple[BagDrive, Stamp, dict[str, str], str]:
    """Return a drive whose messages are whole, and wrong."""
    drive, topics = small_drive(duration=30.0), dict(TOPIC_TYPES)
    kind = rng.choice(("type", "value", "stamp", "topic", "place", "axes"))
    if kind == "type":
        one, other = rng.sample(sorted(topics), 2)
        topics[one], topics[other] = topics[other], topics[one]
        return drive, _true_stamp, topics, f"the types of {one} and {other} are exchanged"
    if kind == "topic":
        gone = rng.choice(sorted(topics))
        del topics[gone]
        return drive, _true_stamp, topics, f"{gone} is missing"
    if kind == "value":
        name = rng.choice(("rates", "accelerations", "speeds", "turns", "places"))
        value = rng.choice((math.nan, math.inf, -math.inf, 1e300, -1e300, 1e9, 0.0))
        values = getattr(drive, name).copy()
        values[rng.randrange(len(values)) :] = value
        return (
            drive._replace(**{name: values}),
            _true_stamp,
            topics,
            f"{name} are {value} from some moment on",
        )
    if kind == "place":
        places = drive.places[:, ::-1] if rng.random() < 0.5 else np.zeros_like(drive.places)
        return drive._replace(places=places), _true_stamp, topics, "places are exchanged or zero"
    if kind == "axes":
        order = rng.choice(([1, 2, 0], [2, 0, 1], [0, 2, 1]))
        turned = drive._replace(rates=drive.rates[:, order], accelerations=drive.accelerations[:, order])
        return turned, _true_stamp, topics, f"the IMU's axes are {order}"
    at, by = rng.uniform(5.0, 25.0), rng.choice((-START_TIME_S, -20.0, 3600.0, 4.0e8))
    which = rng.choice([*topics, "all"])

    def stamp(topic: str, time: float) -> float:
        return max(0.0, START_TIME_S + time + (by if time > at and which in (topic, "all") else 0.0))

    return drive, stamp, topics, f"stamps of {which} are {by:+.0f} s off after {at:.1f} s"


def _true_stamp(topic: str, time: float) -> float:
    return START_TIME_S + time


def _cut(file: Path, rng: random.Random) -> str:
    content = file.read_bytes()
    at = rng.randrange(len(content))
    file.write_bytes(content[:at])
    return f"cut off after {at} of {len(content)} bytes"


def _flip(file: Path, rng: random.Random) -> str:
    content, count = bytearray(file.read_bytes()), rng.choice((1, 5, 50, 500))
    for _ in range(count):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)
    return f"{count} bits are flipped"


def _flip_head(file: Path, rng: random.Random) -> str:
    content = bytearray(file.read_bytes())
    at = rng.randrange(min(4096, len(content)))
    content[at] ^= 1 << rng.randrange(8)
    file.write_bytes(content)
    return f"a bit of byte {at} is flipped"


def _block(file: Path, rng: random.Random) -> str:
    content = bytearray(file.read_bytes())
    size = min(len(content), rng.choice((16, 512, 4096, 65536)))
    at = rng.randrange(len(content) - size + 1)
    content[at : at + size] = rng.choice((bytes(size), rng.randbytes(size)))
    file.write_bytes(content)
    return f"{size} bytes from {at} on are others"


def _double(file: Path, rng: random.Random) -> str:
    content = file.read_bytes()
    at = rng.randrange(len(content))
    file.write_bytes(content[:at] + content[at // 2 : at] + content[at:])
    return f"a part before byte {at} is there twice"


def _empty(file: Path, rng: random.Random) -> str:
    file.write_bytes(rng.choice((b"", b"\x00" * 100, b"no bag", bytes([0x89]) + b"MCAP0\r\n")))
    return "the file holds nothing"


def _other_suffix(file: Path, rng: random.Random) -> str:
    other = file.with_suffix(rng.choice((".mcap", ".db3", ".bag")))
    shutil.copy(file, other) if other != file else None
    return f"beside it is a copy {other.suffix}"


def _break_metadata(path: Path, rng: random.Random) -> str:
    text = path.read_text(encoding="utf-8")
    kind = rng.choice(("gone", "cut", "number", "key", "none", "binary"))
    if kind == "gone":
        path.unlink()
    elif kind == "cut":
        path.write_text(text[: rng.randrange(len(text))], encoding="utf-8")
    elif kind == "number":
        lines = text.splitlines()
        at = rng.randrange(len(lines))
        head = lines[at].partition(":")[0]
        lines[at] = f"{head}: {rng.choice(('-1', '[]', 'x', '1e999', '{a: 1}', 'null'))}"
        path.write_text("\n".join(lines), encoding="utf-8")
    elif kind == "key":
        lines = text.splitlines()
        del lines[rng.randrange(len(lines))]
        path.write_text("\n".join(lines), encoding="utf-8")
    else:
        path.write_bytes(b"" if kind == "none" else rng.randbytes(300))
    return f"metadata.yaml is broken ({kind})"


_BYTES: tuple[Callable[[Path, random.Random], str], ...] = (
    _cut,
    _cut,
    _flip,
    _flip_head,
    _block,
    _double,
    _empty,
    _other_suffix,
)

if __name__ == "__main__":
    main()
