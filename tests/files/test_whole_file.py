"""Files that are there whole, or as they were."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.files.whole_file import write_whole


def test_a_file_is_replaced_and_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "note.txt"
    write_whole(path, "one")
    path.chmod(0o640)
    write_whole(path, b"two")
    assert path.read_text() == "two"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert os.listdir(tmp_path) == ["note.txt"]


@pytest.mark.parametrize("error", [OSError(28, "full"), KeyboardInterrupt()])
def test_what_breaks_off_leaves_the_old_content_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    path = tmp_path / "note.txt"
    path.write_text("old")

    def fails(_file: int) -> None:
        raise error

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(type(error)):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["note.txt"]


def test_a_link_is_replaced_and_never_followed(tmp_path: Path) -> None:
    """D14: also where what is written first would be."""
    outside, path = tmp_path / "outside", tmp_path / "run" / "summary.json"
    path.parent.mkdir()
    outside.write_text("mine")
    path.symlink_to(outside)
    (path.parent / f".summary.json.{os.getpid()}.new").symlink_to(outside)
    write_whole(path, "new")
    assert (outside.read_text(), path.read_text(), path.is_symlink()) == ("mine", "new", False)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_what_is_no_file_stays(tmp_path: Path, make: Callable[[Path], None]) -> None:
    path = tmp_path / "thing"
    make(path)
    with pytest.raises(OSError, match="not a regular file"):
        write_whole(path, "new")
    assert os.listdir(tmp_path) == ["thing"]
