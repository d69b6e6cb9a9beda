"""Check damaged EDS and DCF files: `python -m benchmarks.damage.mutated_eds [--files N] [--seed N]`

Each is the description of the shipped drive with one thing broken or respelled: lines doubled, moved or gone,
numbers of nonsense or octal, keys in another case, bytes flipped, another encoding, cut off. `handcart check`
of a robot that names it has to accept it or to refuse it in words: no traceback, no status 5.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import random
import re
import shutil
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from rich.progress import track

REPOSITORY_ROOT = Path(__file__).resolve().parents[2]
CART, DRIVE = (
    REPOSITORY_ROOT / "backends" / "robots" / "cart",
    REPOSITORY_ROOT / "backends" / "can" / "drives" / "drive.eds",
)
ALLOWED_STATUSES = (0, 2)
NONSENSE_VALUES = (
    "",
    "-1",
    "0x",
    "1e5",
    "08",
    "017",
    "0x1F4",
    "auto",
    "$NODEID+",
    "ä",
    "9" * 400,
    "\x00",
    "0xFFFFFFFFFF",
)
FILE_TAILS = (
    "\x1a",
    "\x00" * 9,
    "\n[6040]\n",
    "\n[",
    "\n=\n",
    "\n[70000]\nParameterName=x\n",
    "\n[6099sub0]\n",
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--files", type=int, default=200, help="default 200")
    parser.add_argument("--seed", type=int, default=0, help="of the first file (default 0)")
    parser.add_argument("--show", action="store_true", help="print what was broken and what was said of it")
    chosen = parser.parse_args()
    statuses, failures = Counter[int](), list[str]()
    with tempfile.TemporaryDirectory() as folder:
        robot = robot_with_eds(Path(folder))
        for seed in track(range(chosen.seed, chosen.seed + chosen.files), "files"):
            content, words = mutated_eds(seed)
            (robot.parent / "maker.eds").write_bytes(content)
            status, err = checked(robot)
            statuses[status] += 1
            if status not in ALLOWED_STATUSES or "Traceback" in err:
                failures.append(f"seed {seed}: {words}: status {status}, {err.strip().splitlines()[-1:]}")
            if chosen.show:
                print(f"seed {seed}: {words}: status {status}: {err.strip().splitlines()[:1]}")
    print("\n".join(failures))
    counts = ", ".join(f"status {status}: {count}" for status, count in sorted(statuses.items()))
    print(f"{chosen.files} mutated EDS: {counts}; status 5: {statuses[5]}")
    sys.exit(1 if failures else 0)


def robot_with_eds(folder: Path) -> Path:
    """Write the cart with a left drive that `maker.eds` beside it describes; return its file."""
    shutil.copytree(CART, folder, dirs_exist_ok=True)
    robot = folder / "robot.yaml"
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace("left: {node: 1,", "left: {node: 1, eds: maker.eds,"), encoding="utf-8")
    return robot


def mutated_eds(seed: int) -> tuple[bytes, str]:
    """Return an EDS with one to three things broken, and what; the same for the same seed."""
    rng = random.Random(seed)
    text, said = DRIVE.read_text(encoding="utf-8"), list[str]()
    for _ in range(rng.choice((1, 1, 2, 3))):
        mutate = rng.choice(_TEXTS)
        text = mutate(text, rng)
        said.append(mutate.__name__.strip("_").replace("_", " "))
    content = text.encode(rng.choice(("utf-8", "utf-8", "utf-8-sig", "cp1252", "utf-16")), errors="replace")
    if rng.random() < 0.3:
        content = _flipped(content, rng)
        said.append("bits flipped")
    return content, ", ".join(said)


def checked(robot: Path) -> tuple[int, str]:
    """Return status and stderr of `handcart check`."""
    from handcart.tools.main import main as handcart

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            handcart(["check", str(robot)])
        except SystemExit as end:
            return int(end.code or 0), err.getvalue()
    return 0, err.getvalue()


def _flipped(content: bytes, rng: random.Random) -> bytes:
    changed = bytearray(content)
    for _ in range(rng.choice((1, 5, 50)) if content else 0):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _nonsense_value(text: str, rng: random.Random) -> str:
    places = [match.span(1) for match in re.finditer(r"=(.*)", text)]
    start, end = rng.choice(places or [(0, 0)])
    return text[:start] + rng.choice(NONSENSE_VALUES) + text[end:]


def _other_case(text: str, rng: random.Random) -> str:
    change: Callable[[str], str] = rng.choice((str.lower, str.upper))
    keys = sorted(set(re.findall(r"(?m)^(\w+)=", text)) | set(re.findall(r"(?m)^\[(\w+)\]", text)))
    key = rng.choice(keys or ["none"])
    return re.sub(rf"(?m)^(\[?){key}(?=[\]=])", lambda found: found[1] + change(key), text)


def _line_gone(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    del lines[rng.randrange(len(lines))]
    return "\n".join(lines)


def _line_doubled(text: str, rng: random.Random) -> str:
    lines = text.split("\n")
    line = rng.choice(lines)
    lines.insert(rng.randrange(len(lines)), line)
    return "\n".join(lines)


def _cut_off(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text) + 1)]


def _other_line_ends(text: str, rng: random.Random) -> str:
    return text.replace("\n", rng.choice(("\r\n", "\r")))


def _tail(text: str, rng: random.Random) -> str:
    return text + rng.choice(FILE_TAILS)


def _section_gone(text: str, rng: random.Random) -> str:
    parts = re.split(r"(?m)^(?=\[)", text)
    del parts[rng.randrange(len(parts))]
    return "".join(parts)


def _sections_shuffled(text: str, rng: random.Random) -> str:
    first, *parts = re.split(r"(?m)^(?=\[)", text)
    rng.shuffle(parts)
    return first + "".join(parts)


_TEXTS = (
    _nonsense_value,
    _nonsense_value,
    _other_case,
    _line_gone,
    _line_doubled,
    _cut_off,
    _other_line_ends,
    _tail,
    _section_gone,
    _sections_shuffled,
)

if __name__ == "__main__":
    main()
