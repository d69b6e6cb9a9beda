"""Paths that must not leave their root (row T13: more than forty ways to try)."""

import os
import unicodedata
from pathlib import Path

import pytest

from handcart.files.errors import UnsafePath
from handcart.files.inside import portable, resolve_inside

VECTORS = [
    *("", " ", ".", "./", "..", "../", "./..", "a/..", "a/../..", "../../etc/passwd", "../x", "a/../../x"),
    *(
        "a/b/../../../x",
        "./../x",
        "....//../../x",
        "../root",
        "../rootless/x",
        "a/./../../x",
        "sub/../../root2/x",
    ),
    *("/", "//", "/etc/passwd", "//server/share/x", "///x", "/../x"),
    *("~", "~/x", "~root/x"),
    *(
        "C:",
        "C:x",
        "C:/x",
        "C:\\x",
        "c:\\..\\x",
        "\\\\server\\share",
        "\\x",
        "..\\..\\x",
        "a\\..\\b",
        "\\\\?\\C:\\x",
    ),
    *("file:///etc/passwd", "http://x/y", "x:stream"),
    *("a\0b", "\0", "../\0", "a\nb", "a\x1b[2Jb", "a\u202eb", "a" * 2000, "a/" * 600 + "x"),
    *("out/x", "out", "a/up/../../x", "up/up/x", "loop", "loop/x", "far"),
]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    root = tmp_path / "root"
    (root / "a").mkdir(parents=True)
    (root / "sub").mkdir()
    (tmp_path / "root2").mkdir()
    (root / "out").symlink_to("/etc")
    (root / "up").symlink_to("..")
    (root / "a" / "up").symlink_to("../..")
    (root / "loop").symlink_to("loop")
    (root / "far").symlink_to("/etc/passwd")
    (root / "in").symlink_to("a")
    return root


@pytest.mark.parametrize("path", VECTORS, ids=[ascii(path)[:24] for path in VECTORS])
def test_t13_escapes_are_refused(root: Path, path: str) -> None:
    with pytest.raises(UnsafePath) as caught:
        resolve_inside(root, path)
    assert str(caught.value).isprintable()
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("path", "end"),
    [
        ("a/x.yaml", "a/x.yaml"),
        ("a/../x", "x"),
        ("in/x", "a/x"),
        ("...", "..."),
        ("ä b/ñ", "ä b/ñ"),
        ("./x", "x"),
    ],
)
def test_inside_is_allowed(root: Path, path: str, end: str) -> None:
    assert resolve_inside(root, path) == root.resolve() / end


def test_a_start_inside_the_root(root: Path) -> None:
    assert resolve_inside(root, "../sub/x", start=root / "a") == root.resolve() / "sub" / "x"
    with pytest.raises(UnsafePath, match="leads out of"):
        resolve_inside(root, "../../x", start=root / "a")


def test_a_root_that_is_a_link(root: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(root)
    assert resolve_inside(tmp_path / "link", "a/x") == Path(os.path.realpath(root)) / "a" / "x"


def test_portable_keeps_the_text() -> None:
    assert portable("../maps/x.yaml") == "../maps/x.yaml"


def test_file_with_decomposed_accents_is_found_by_its_composed_name(tmp_path: Path) -> None:
    decomposed = tmp_path / unicodedata.normalize("NFD", "Küche.yaml")
    decomposed.write_text("", encoding="utf-8")
    assert resolve_inside(tmp_path, unicodedata.normalize("NFC", "Küche.yaml")) == decomposed.resolve()
