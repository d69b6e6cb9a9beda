"""Reading of a complete regular file with a limit on its size, without ever waiting."""

import errno
import os
import re
import stat
from pathlib import Path
from typing import BinaryIO

from handcart.files.errors import FileError, Finding
from handcart.files.suggest import did_you_mean

MAX_LINE = 20_000
"""Maximum length of a line, in characters. The YAML parser's time is quadratic, 8 s for a tag of 1 MiB."""
ALLOWED_FILE = "a regular file that can be read"
BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Byte order mark in UTF-8, which some programs write at the beginning of a text."""
_MARKS = (
    (BYTE_ORDER_MARK, "a UTF-8 byte order mark"),
    (b"\xff\xfe", "a UTF-16 byte order mark"),
    (b"\xfe\xff", "a UTF-16 byte order mark"),
)
_CONTROL = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")


def read_regular_file(path: Path | str, max_bytes: int) -> bytes:
    """Return the bytes of the regular file `path`.

    A pipe without a writer is not waited for.

    Raises:
        FileError: the path is missing or may not be read; is a directory, pipe or device; or the file has
            more than `max_bytes`, and is then not read at all.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    except FileNotFoundError as error:
        raise _refused(path, _cause(error), meant=did_you_mean(Path(path))) from None
    except (OSError, ValueError) as error:
        raise _refused(path, _cause(error)) from None
    try:
        with os.fdopen(descriptor, "rb", closefd=True) as stream:
            status = os.fstat(stream.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise _refused(path, f"is {_kind(status.st_mode)}")
            content = stream.read(max_bytes + 1) if status.st_size <= max_bytes else None
    except IsADirectoryError:
        raise _refused(path, "is a directory", _inside(Path(path))) from None
    except OSError as error:
        raise _refused(path, _cause(error)) from None
    if content is None or len(content) > max_bytes:
        raise _refused(path, f"has {status.st_size} bytes", f"at most {max_bytes}")
    return content


def open_regular(path: Path | str) -> BinaryIO:
    """Open a regular file for reading, without waiting if the path is a pipe without a writer.

    Raises:
        OSError: the file cannot be opened, or is not a regular file.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    try:
        check_regular(descriptor)
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


def check_regular(descriptor: int) -> None:
    """Raise OSError if an open file is not a regular one."""
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, f"it is {_kind(mode)}, no regular file")


def decode_text(content: bytes, file: str, longest_line: int | None = MAX_LINE) -> str:
    """Return the text of UTF-8 bytes.

    Args:
        content: bytes of the file.
        file: name of the file in messages.
        longest_line: largest length of a line, in characters; None: any length.

    Raises:
        FileError: at the first byte that is not UTF-8, at a control character, at a byte order mark or at a
            line of more than `longest_line` characters.
    """
    for mark, name in _MARKS:
        if content.startswith(mark):
            raise FileError([Finding(file, 1, 1, f"starts with {name}; allowed: plain UTF-8 without one")])
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8")
        wrong = f"the byte 0x{content[error.start]:02x} is not UTF-8; allowed: UTF-8"
        raise FileError([_at_end_of(before, file, wrong)]) from None
    if found := _CONTROL.search(text):
        wrong = f"the character U+{ord(found.group()):04X} can't be printed; allowed: printable characters"
        raise FileError([_at_end_of(text[: found.start()], file, wrong)])
    overlong = re.search(rf"(?m:^)[^\n]{{{longest_line + 1}}}", text) if longest_line else None
    if overlong:
        wrong = f"a line of more than {longest_line} characters; allowed: shorter ones"
        raise FileError([_at_end_of(text[: overlong.start()], file, wrong)])
    return text


def _at_end_of(before: str, file: str, message: str) -> Finding:
    # Only these three break lines in YAML 1.2; str.splitlines knows eight more.
    lines = before.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return Finding(file, len(lines), len(lines[-1]) + 1, message)


def _inside(folder: Path) -> str:
    """Return a file that may have been meant: the task file in the folder, otherwise its first YAML file."""
    found = sorted(folder.glob("*.yaml"), key=lambda path: (path.name != "task.yaml", path.name))
    return f"a file, such as {found[0]}" if found else ALLOWED_FILE


def _refused(path: Path | str, wrong: str, allowed: str = ALLOWED_FILE, meant: str = "") -> FileError:
    return FileError([Finding(str(path), 1, 1, f"the file {wrong}; {meant}allowed: {allowed}")])


def _cause(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "does not exist"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be read ({error.strerror.lower()})"
    return "has an impossible name"


def _kind(mode: int) -> str:
    kinds = ((stat.S_ISDIR, "a directory"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
    return next((name for test, name in kinds if test(mode)), "a device")
