"""Entry points of other packages: those of a group; the standard library is asked where there are any."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import pytest

from handcart.files.plugins import entry_points_of

GROUP = "handcart.tests"
METADATA = "Metadata-Version: 2.1\nName: {0}\nVersion: 1.0\n"


def package(folder: Path, name: str, points: str) -> None:
    """Write the files that pip leaves of a package."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(METADATA.format(name), encoding="utf-8")
    (info / "entry_points.txt").write_text(points, encoding="utf-8")


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is on Python's path, alone."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), str(tmp_path / "gone")])
    return tmp_path


def test_those_of_the_group_come_by_their_names(path: Path) -> None:
    package(path, "one", f"[{GROUP}]\nzinnia = one:Z\nmint = one:M\n\n[console_scripts]\nbasil = one:main\n")
    package(path, "two", f"[other.{GROUP}]\nmint = two:M\n")
    package(path, "three", f"[{GROUP}]\naster = three:A\n")
    assert [(point.name, point.value) for point in entry_points_of(GROUP)] == [
        ("aster", "three:A"),
        ("mint", "one:M"),
        ("zinnia", "one:Z"),
    ]


def test_where_no_package_has_the_group_nothing_slow_is_asked(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package(path, "one", "[console_scripts]\nbasil = one:main\n")
    monkeypatch.setitem(sys.modules, "importlib.metadata", None)
    assert entry_points_of(GROUP) == []


def test_an_archive_on_the_path_is_looked_into(path: Path) -> None:
    archive = path / "packed.zip"
    with zipfile.ZipFile(archive, "w") as packed:
        packed.writestr("packed-1.0.dist-info/METADATA", METADATA.format("packed"))
        packed.writestr("packed-1.0.dist-info/entry_points.txt", f"[{GROUP}]\nmint = packed:M\n")
    sys.path.append(str(archive))
    assert [point.name for point in entry_points_of(GROUP)] == ["mint"]


def test_declarations_that_are_rewritten_in_place_are_read_again(path: Path) -> None:
    """As by a development install: the folder's own time of change stays."""
    package(path, "one", "[console_scripts]\nbasil = one:main\n")
    assert entry_points_of(GROUP) == []
    file, changed = path / "one-1.0.dist-info" / "entry_points.txt", path.stat().st_mtime_ns
    for name in ("mint", "aster"):
        file.write_text(f"[{GROUP}]\n{name} = one:M\n", encoding="utf-8")
        assert path.stat().st_mtime_ns == changed
        assert [point.name for point in entry_points_of(GROUP)] == [name]
