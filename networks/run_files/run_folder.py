"""Reading of a run's folder, safe against entries that lead out of it, never answer, or are too large."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.networks.journal.journal_record import MAX_JOURNAL, JournalContents, JournalError, parse_journal
from handcart.networks.journal.run_records import makes_sense

from .socket_path import CONTROL_SOCKET, STOP_SOCKET

JOURNAL_FILE = "journal.jsonl"
SOCKET_NAMES = (CONTROL_SOCKET, STOP_SOCKET)
"""Sockets on which a run receives its operator's commands; only these may be no plain files."""
_MOST = 50_000  # files of a run
_DEEPEST = 4  # folders in it
_KINDS = (
    (stat.S_ISLNK, "a link"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISCHR, "a device"),
)


class NoRun(InputError):
    """Error: a folder holds no readable run; nothing in it was changed."""

    def __init__(self, folder: Path, wrong: str) -> None:
        super().__init__(
            printable(f"{folder}: {wrong}; allowed: the folder of a run, such as runs/return_book-0")
        )


def check_folder(folder: Path) -> None:
    """Check that a folder holds plain files and folders alone, so that later writes stay inside it.

    Raises:
        NoRun: it is not a folder, or something in it is a link, a pipe, a device or a hard link.
    """
    try:
        if not stat.S_ISDIR(os.stat(folder).st_mode):
            raise NoRun(folder, "it is no folder")
        for number, (path, status) in enumerate(_inside(folder, _DEEPEST)):
            if number >= _MOST:
                raise NoRun(folder, f"there are more than {_MOST} files in it")
            _check(folder, path, status)
    except FileNotFoundError:
        wrong = "it is a link to nothing" if os.path.islink(folder) else "there is no such folder"
        raise NoRun(folder, wrong) from None
    except (OSError, ValueError) as error:
        if isinstance(error, NoRun):
            raise
        raise NoRun(folder, f"it can't be read: {getattr(error, 'strerror', None) or error}") from None


def _inside(folder: Path, levels: int) -> Iterator[tuple[Path, os.stat_result]]:
    with os.scandir(folder) as entries:
        for entry in entries:
            status = entry.stat(follow_symlinks=False)
            yield Path(entry.path), status
            if stat.S_ISDIR(status.st_mode):
                if levels == 0:
                    raise NoRun(folder, f"there are folders in folders, more than {_DEEPEST} deep")
                yield from _inside(Path(entry.path), levels - 1)


def _check(folder: Path, path: Path, status: os.stat_result) -> None:
    name = path.relative_to(folder)
    if stat.S_ISDIR(status.st_mode):
        if str(name) in (JOURNAL_FILE, "checkpoint", "summary.json", "telemetry.npz"):
            raise NoRun(folder, f"{name} in it is a folder; a run has a file of that name")
    elif stat.S_ISREG(status.st_mode):
        if status.st_nlink > 1:
            raise NoRun(folder, f"{name} in it has another name elsewhere (a hard link)")
    elif not (stat.S_ISSOCK(status.st_mode) and str(name) in SOCKET_NAMES):
        kind = next(words for test, words in _KINDS if test(status.st_mode))
        raise NoRun(folder, f"{name} in it is {kind}")


def read_file(folder: Path, name: str, most: int, missing: bool = False) -> bytes | None:
    """Return the content of a regular file of a run; None if it is missing and that is allowed.

    Args:
        folder: the run's folder.
        name: name of the file in it.
        most: maximum size, in [bytes].
        missing: True if the file may be missing.

    Raises:
        NoRun: the file is missing, not a regular file, too large, or cannot be read.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NOCTTY
    try:
        with open(os.open(folder / name, flags), "rb") as stream:
            status = os.fstat(stream.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise NoRun(folder, f"{name} in it is no file")
            content = stream.read(most + 1)
    except FileNotFoundError:
        if missing:
            return None
        where = f"there is no {name} in it" if folder.is_dir() else "there is no such folder"
        raise NoRun(folder, where) from None
    except OSError as error:
        raise NoRun(folder, f"{name} in it can't be read: {error.strerror}") from None
    if len(content) > most:
        raise NoRun(folder, f"{name} in it has {status.st_size} bytes, more than {most}")
    return content


def read_run_journal(folder: Path) -> JournalContents:
    """Read and check the journal in a run's folder: each record byte by byte, and its fields' types.

    Raises:
        NoRun: the journal is missing, or something in the folder is not a plain file.
        JournalError: a record before the last one is damaged, or the fields of a record make no sense.
    """
    check_folder(folder)
    content = read_file(folder, JOURNAL_FILE, MAX_JOURNAL)
    assert content is not None
    contents = parse_journal(folder / JOURNAL_FILE, content)
    for record in contents.records:
        wrong = makes_sense(record)
        if wrong:
            kind = str(record["kind"])[:40]
            words = f"record {record['q']} ({kind}) makes no sense: {wrong}"
            raise JournalError(folder / JOURNAL_FILE, words)
    return contents
