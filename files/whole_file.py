"""Writing a file whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from pathlib import Path

_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW


def write_whole(path: Path, content: bytes | str, *, sync: bool = True, private: bool = False) -> None:
    """Write a file atomically: readers, and a crash at any time, find the old content or the new.

    The new file keeps the old one's mode. A link at the path is replaced, never followed.

    Args:
        path: path of the file.
        content: bytes of the file, or its text, which is written as UTF-8.
        sync: whether the old or the new content survives a power cut as well; that takes a moment.
        private: whether only its owner may read a new file.

    Raises:
        OSError: the file cannot be written, or the existing one is not a regular file; nothing has changed.
    """
    raw = content.encode() if isinstance(content, str) else content
    mode = _mode(path)
    new = path.with_name(f".{path.name[:40]}.{os.getpid()}.new")
    new.unlink(missing_ok=True)  # of a process that had the same number, and was killed
    try:
        with open(os.open(new, _FLAGS, 0o600 if private else 0o666), "wb") as file:
            if mode is not None:
                os.fchmod(file.fileno(), mode)
            file.write(raw)
            if sync:
                file.flush()
                os.fsync(file.fileno())
        os.replace(new, path)
    except BaseException:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def sync_folder(folder: Path) -> None:
    """Write a folder's list of files to the disk, so that a power cut does not lose a new file.

    Raises:
        OSError: the folder cannot be opened or written.
    """
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _mode(path: Path) -> int | None:
    try:
        there = path.lstat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(there):
        return None
    if not stat.S_ISREG(there):
        raise OSError(errno.EINVAL, "it is not a regular file")
    return stat.S_IMODE(there)
