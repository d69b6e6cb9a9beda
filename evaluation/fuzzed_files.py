"""Files as strangers write them: the shipped ones, damaged at random, seeded."""

from __future__ import annotations

import random
import signal
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from types import FrameType

from files.errors import HandcartError

LIBRARY = Path(__file__).parent.parent / "tasks" / "return_book"
ROBOT = Path(__file__).parent.parent / "backends" / "robots" / "librarian"
LONGEST = 10  # [s] that a check may take
_WORDS = (
    "", "~", "null", "true", "-1", "0", "1e309", ".nan", ".inf", "-.inf", "1:30", "012", "0x1F", "1e-3",
    "2026-11-21", "'", '"', "[", "]", "{", "}", "&a", "*a", "<<: *a", "!!python/object/apply:os.system [ls]",
    "!x y", "|", ">", "---", "...", "#", "\t", "\x00", "\x1b[31m", "\ufeff", "é", "𝔸", "../../etc/passwd",
    "/dev/zero", "C:\\x", "a" * 300, "- " * 40, "{a: " * 40, "? ", "? [x]", ": ", "[[[[", "<<", "=",
    "%YAML 9.9", "@", "`",
)  # fmt: skip


@dataclass(frozen=True)
class Failure:
    """A damaged file that wasn't met with a clear error."""

    number: int
    name: str
    content: bytes
    why: str


def sources() -> dict[str, bytes]:
    """The files that are damaged, by name, with those that they need beside them."""
    found = {path.name: path.read_bytes() for path in LIBRARY.iterdir() if path.is_file()}
    found["robot.yaml"] = (ROBOT / "robot.yaml").read_bytes()
    found |= {path.name: path.read_bytes() for path in ROBOT.glob("*.urdf")}
    return found


def damaged(content: bytes, rng: random.Random) -> bytes:
    """A file with up to six damages: bytes flipped, lines lost, doubled or swapped, words put in."""
    lines = content.split(b"\n")
    for _ in range(rng.randint(1, 6)):
        kind, at = rng.randrange(6), rng.randrange(len(lines))
        line = lines[at]
        if kind == 0:
            lines.pop(at)
            lines = lines or [b""]
        elif kind == 1:
            lines.insert(at, lines[rng.randrange(len(lines))])
        elif kind == 2:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif kind == 3 and line:
            place = rng.randrange(len(line))
            lines[at] = line[:place] + bytes([rng.randrange(256)]) + line[place + 1 :]
        elif kind == 4:
            place = rng.randint(0, len(line))
            lines[at] = line[:place] + rng.choice(_WORDS).encode() + line[place:]
        else:
            key, colon, _ = line.partition(b": ")
            lines[at] = key + colon + rng.choice(_WORDS).encode()
    return b"\n".join(lines)


def fuzz(
    folder: Path, count: int, check: Callable[[Path], object], seed: int = 0
) -> Iterator[Failure | None]:
    """Check that many damaged files in an empty folder; each gives None, or what went wrong.

    Wrong is: another exception than an error for the user, more than 10 s, a file that was written.
    """
    rng, whole = random.Random(seed), sources()
    for name, content in whole.items():
        (folder / name).write_bytes(content)
    names = sorted(name for name in whole if name.endswith(".yaml"))
    for number in range(count):
        name = rng.choice(names)
        content = damaged(whole[name], rng)
        (folder / name).write_bytes(content)
        before = _fingerprint(folder)
        why = _why(folder / name, check)
        if not why and _fingerprint(folder) != before:
            why = "a file was written"
        (folder / name).write_bytes(whole[name])
        yield Failure(number, name, content, why) if why else None


def _why(path: Path, check: Callable[[Path], object]) -> str:
    before = signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(LONGEST)
    try:
        check(path)
    except HandcartError as error:
        return "" if str(error).strip() else "an error without words"
    except TimeoutError:
        return f"longer than {LONGEST} s"
    except Exception:
        return traceback.format_exc()
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    return ""


def _too_long(_number: int, _frame: FrameType | None) -> None:
    raise TimeoutError


def _fingerprint(folder: Path) -> bytes:
    digest = blake2b()
    for path in sorted(folder.rglob("*")):
        digest.update(str(path).encode() + (path.read_bytes() if path.is_file() else b""))
    return digest.digest()
