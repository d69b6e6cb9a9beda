"""A run in an archive, `.zip` or `.tar` with any compression: opened like a folder."""

from __future__ import annotations

import tarfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from .run_folder import JOURNAL_FILE, NoRun

MAX_ARCHIVED_BYTES = 2**30
MAX_ARCHIVED_FILES = 50_000
Content = tuple[str, int]
"""Name of a plain file in an archive, and its size in [bytes]."""


@contextmanager
def opened_run(path: Path) -> Iterator[Path]:
    """Yield the folder of a run: the path itself, or a temporary folder with the content of an archive.

    Raises:
        NoRun: the archive cannot be read, does not hold exactly one run, or is too large.
    """
    if not path.is_file():
        yield path
        return
    with TemporaryDirectory(prefix="run-") as folder:
        try:
            _unpack(path, Path(folder))
        except (OSError, EOFError, ValueError, RuntimeError, tarfile.TarError, zipfile.BadZipFile) as error:
            wrong = str(error).partition("\n")[0].rstrip(":")
            raise NoRun(path, f"the archive is not readable ({wrong})") from None
        yield Path(folder)


def _unpack(path: Path, folder: Path) -> None:
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as packed:
            listed = (item for item in packed.infolist() if not item.is_dir())
            files = _bounded(path, ((item.filename, item.file_size) for item in listed))
            for name, target in _chosen(path, files, folder):
                _write(path, target, packed.open(name).read(MAX_ARCHIVED_BYTES + 1))
        return
    with tarfile.open(path) as archive:
        files = _bounded(path, ((item.name, item.size) for item in archive if item.isreg()))
        for name, target in _chosen(path, files, folder):
            source = archive.extractfile(name)
            assert source is not None
            _write(path, target, source.read(MAX_ARCHIVED_BYTES + 1))


def _bounded(path: Path, files: Iterator[Content]) -> list[str]:
    """Return the names of an archive's files; names beyond the allowed number are not read."""
    names, total = [], 0
    for name, size in files:
        names.append(name)
        total += size
        if len(names) > MAX_ARCHIVED_FILES or total > MAX_ARCHIVED_BYTES:
            raise NoRun(path, f"it holds more than {MAX_ARCHIVED_FILES} files or {MAX_ARCHIVED_BYTES} bytes")
    return names


def _chosen(path: Path, files: list[str], folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the files of the archive's run, each with the place to write it to."""
    tops = [PurePosixPath(name).parent for name in files if PurePosixPath(name).name == JOURNAL_FILE]
    if len(tops) != 1:
        raise NoRun(path, f"it holds {len(tops)} files {JOURNAL_FILE}, not one")
    for name in files:
        inside = PurePosixPath(name)
        if inside.is_relative_to(tops[0]) and ".." not in inside.parts:
            yield name, folder / inside.relative_to(tops[0])


def _write(path: Path, target: Path, content: bytes) -> None:
    if len(content) > MAX_ARCHIVED_BYTES:
        raise NoRun(path, f"it holds more than {MAX_ARCHIVED_BYTES} bytes")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(content)
