"""Files as strangers write them: the shipped ones, damaged at random, seeded."""

from __future__ import annotations

import random
import resource
import signal
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from types import FrameType

from handcart.files.errors import HandcartError

LIBRARY_FOLDER = Path(__file__).parent.parent.parent / "tasks" / "return_book"
ROBOT_FOLDER = Path(__file__).parent.parent.parent / "backends" / "robots" / "librarian"
MAX_CHECK_CPU_S = 10  # [s] of the processor's time that a check may take
MAX_CHECK_WALL_S = 100  # [s] that it may take on a busy machine; longer, and it hangs
MAX_REREAD_BYTES = 1 << 22  # [bytes] of files that are read again to see whether they were written
MAX_MEMORY_BYTES = 1 << 30  # [bytes] beside what the process has already
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
    """Return the files that are damaged, by name, with those that they need beside them."""
    found = {path.name: path.read_bytes() for path in LIBRARY_FOLDER.iterdir() if path.is_file()}
    found["robot.yaml"] = (ROBOT_FOLDER / "robot.yaml").read_bytes()
    found |= {path.name: path.read_bytes() for path in ROBOT_FOLDER.glob("*.urdf")}
    return found


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Return a file with up to six damages: bytes flipped, lines lost, doubled or swapped, words put in."""
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

    Wrong is: another exception than an error for the user, more than `LONGEST` seconds or `MEMORY` bytes, a
    file that was written.
    """
    rng, whole = random.Random(seed), sources()
    for name, content in whole.items():
        (folder / name).write_bytes(content)
    names = sorted(name for name in whole if name.endswith(".yaml"))
    for number in range(count):
        name = rng.choice(names)
        content = damaged(whole[name], rng)
        (folder / name).write_bytes(content)
        why = why_not(folder, folder / name, check)
        (folder / name).write_bytes(whole[name])
        yield Failure(number, name, content, why) if why else None


def why_not(folder: Path, path: Path, check: Callable[[Path], object]) -> str:
    """Return the violation when a file in a folder is checked; "" if it passes or is refused with a
    message.
    """
    before = _fingerprint(folder)
    try:
        with _at_most(MAX_CHECK_CPU_S, MAX_MEMORY_BYTES):
            check(path)
    except HandcartError as error:
        if not str(error).strip():
            return "an error without words"
    except TimeoutError:
        return f"longer than {MAX_CHECK_CPU_S} s"
    except Exception:
        return traceback.format_exc()
    return "" if _fingerprint(folder) == before else "a file was written"


@contextmanager
def _at_most(seconds: int, memory: int) -> Iterator[None]:
    """Raise TimeoutError after that CPU time or `MAX_CHECK_WALL_S`, MemoryError beyond those bytes."""
    handlers = {item: signal.signal(item, _too_long) for item in (signal.SIGALRM, signal.SIGPROF)}
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + memory, hard))
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.alarm(MAX_CHECK_WALL_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        for number, handler in handlers.items():
            signal.signal(number, handler)


def _too_long(_number: int, _frame: FrameType | None) -> None:
    raise TimeoutError


def _fingerprint(folder: Path) -> bytes:
    digest = blake2b()
    for path in sorted(folder.rglob("*")):
        status = path.lstat()
        whole = path.is_file() and status.st_size < MAX_REREAD_BYTES
        digest.update(f"{path} {status.st_mode} {status.st_size} {status.st_mtime_ns}".encode())
        digest.update(path.read_bytes() if whole else b"")
    return digest.digest()
