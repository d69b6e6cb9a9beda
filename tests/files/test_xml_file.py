"""XML as strangers write it: refused in words, at its line (rows T1, T2, T3, T4, T14)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from handcart.files.errors import FileError
from handcart.files.xml_file import MAX_DEPTH, MAX_NODES, checked_xml, read_xml_text

ENTITIES = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;">]>\n<r>&b;</r>'


def error_of(content: bytes | str, check: Any = None) -> str:
    with pytest.raises(FileError) as error:
        checked_xml(content if isinstance(content, bytes) else content.encode(), "f.urdf", check)
    return str(error.value)


def test_what_is_sound_is_read_as_it_is() -> None:
    text = "<?xml version='1.0' encoding='utf-8'?>\r\n<robot name='é'><link name='a'/></robot>\n"
    assert checked_xml(text.encode(), "f.urdf") == text
    assert checked_xml(b"\xef\xbb\xbf" + text.encode(), "f.urdf") == text
    assert checked_xml(b"<r>" + b"<a b='c'/>" * 5000 + b"</r>", "f.urdf")  # in one line


def test_the_largest_that_is_read() -> None:
    deepest = b"<a>" * MAX_DEPTH + b"</a>" * MAX_DEPTH
    assert checked_xml(deepest, "f.urdf")
    assert checked_xml(b"<r>" + b"<a/>" * (MAX_NODES - 1) + b"</r>", "f.urdf")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (ENTITIES, "f.urdf:1:13: a document type (DOCTYPE); allowed: XML without one"),
        ('<!DOCTYPE r SYSTEM "file:///etc/passwd"><r/>', "a document type"),
        ("<r>" + "<a/>" * MAX_NODES + "</r>", f"more than {MAX_NODES} elements and attributes"),
        ("<a>" * (MAX_DEPTH + 1) + "</a>" * (MAX_DEPTH + 1), f"nested deeper than {MAX_DEPTH}"),
        (
            "<r>\n <a></b>\n</r>",
            "f.urdf:2:7: the file is not well-formed: mismatched tag; allowed: XML in UTF-8",
        ),
        ("", "f.urdf:1:1: the file is not well-formed: no element found"),
        (b"<r>\n\xe9</r>", "f.urdf:2:1: the byte 0xe9 is not UTF-8"),
        (b"<r>\x00</r>", "the character U+0000"),
        ("<r/>".encode("utf-16"), "UTF-16"),
    ],
)
def test_what_is_not_is_refused(content: bytes | str, words: str) -> None:
    assert words in error_of(content)


def test_a_check_is_asked_of_each_element() -> None:
    def no_b(tag: Any) -> Iterator[str]:
        if tag.name == "b":
            yield f"<b> in <{tag.parents[-1].name}>; allowed: <c>"

    assert error_of("<r>\n<a>\n <b/><b/></a></r>", no_b).splitlines() == [
        "f.urdf:3:2: <b> in <a>; allowed: <c>",
        "f.urdf:3:6: <b> in <a>; allowed: <c>",
    ]


def test_a_pipe_a_folder_and_a_huge_file_are_not_read(tmp_path: Path) -> None:
    """A pipe without a writer does not block."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "huge").touch()
    os.truncate(tmp_path / "huge", 10**9)
    for name, words in (("pipe", "is a pipe"), (".", "is a directory"), ("huge", "has 1000000000 bytes")):
        with pytest.raises(FileError, match=words):
            read_xml_text(tmp_path / name)
