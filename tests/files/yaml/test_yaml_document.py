"""Tests of reading YAML: each refusal, with its place and words (rows T1 to T9, T14, T16, T18)."""

import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from handcart.files.errors import FileError, Finding
from handcart.files.yaml.yaml_document import Document, parse_document, read_document


def refusal(text: str | bytes, **limits: int) -> tuple[Finding, ...]:
    content = text.encode() if isinstance(text, str) else text
    with pytest.raises(FileError) as caught:
        parse_document(content, "f.yaml", **limits)
    return caught.value.findings


def test_values_and_positions() -> None:
    document = parse_document(b"a: 1\nb:\n  - x: 1e-3\n    'y z': [true, ~]\n", "f.yaml")
    assert document.data == {"a": 1, "b": [{"x": 0.001, "y z": [True, None]}]}
    assert document.position(("b", 0, "x")) == (3, 8)
    assert document.key_position(("b", 0, "x")) == (3, 5)
    assert document.position(("b", 0, "y z", 1)) == (4, 19)
    assert document.position(("b", 0, "missing", 7)) == (3, 5)
    assert str(document.finding(("a",), "bad; allowed: good")) == "f.yaml:1:4: bad; allowed: good"


def test_positions_with_windows_line_ends() -> None:
    document = parse_document(b"a: 1\r\nb:\r\n  c: 2\r\n", "f.yaml")
    assert document.position(("b", "c")) == (3, 6)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("missing.yaml", "does not exist"),
        (".", "is a directory"),
        ("a\0b", "impossible name"),
        ("/dev/null", "is a device"),
        ("x" * 5000, "cannot be read"),
    ],
)
def test_t01_no_regular_file(tmp_path: Path, name: str, said: str) -> None:
    with pytest.raises(FileError, match=said) as caught:
        read_document(tmp_path / name)
    assert ":1:1: the file " in str(caught.value)


def test_t01_of_a_folder_the_file_that_was_meant_is_named(tmp_path: Path) -> None:
    for name in ("a.yaml", "task.yaml"):
        (tmp_path / name).touch()
        with pytest.raises(FileError, match=f"is a directory; allowed: a file, such as .*/{name}"):
            read_document(tmp_path)


def test_t01_fifo_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    program = (
        "import sys\nfrom handcart.files.errors import FileError\n"
        "from handcart.files.yaml.yaml_document import read_document\n"
        "try:\n    read_document(sys.argv[1])\nexcept FileError as error:\n    sys.exit(str(error))\n"
    )
    # In a process of its own: a read that blocks would hang the suite.
    ended = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "pipe.yaml")],
        timeout=30,
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[3],
    )
    assert "is a pipe" in ended.stderr


def test_t02_too_large_is_not_parsed(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    path.write_bytes(b"[" * ((1 << 20) + 1))
    with pytest.raises(FileError, match="has 1048577 bytes; allowed: at most 1048576"):
        read_document(path)
    path.write_bytes(b"a: 1\n")
    with pytest.raises(FileError, match="at most 3"):
        read_document(path, max_bytes=3)


def bomb() -> str:
    lines = ['a: &a ["lol","lol","lol","lol","lol","lol","lol","lol","lol"]']
    for before, name in zip("abcdefgh", "bcdefghi", strict=True):
        lines.append(f"{name}: &{name} [{','.join([f'*{before}'] * 9)}]")
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        (bomb(), "f.yaml:1:4: the anchor &a; allowed: values without one"),
        ("a: &x {k: 1}\nb:\n  <<: *x\n", "f.yaml:1:4: the anchor &x; allowed: values without one"),
        ("&x [*x]", "f.yaml:1:1: the anchor &x; allowed: values without one"),
        ("a: 1\nb: *nothing", "f.yaml:2:4: the alias *nothing; allowed: the value itself"),
        ("a: 1\n<<: {b: 2}", "f.yaml:2:1: the merge key <<; allowed: keys that are words"),
    ],
)
def test_t03_alias_anchor_merge_key(text: str, first: str) -> None:
    begin = time.process_time()
    findings = refusal(text)
    assert time.process_time() - begin < 0.5  # expanded, the bomb takes 43 s; refused, 2 ms
    assert str(findings[0]) == first


def test_t03_a_quoted_merge_key_is_a_word() -> None:
    assert parse_document(b"'<<': 1", "f.yaml").data == {"<<": 1}


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "{", "? "])
def test_t04_nesting(opening: str) -> None:
    assert refusal(opening * 20_000)


@pytest.mark.slow
def test_t04_depth_and_number_are_told() -> None:
    assert parse_document(b"[" * 32 + b"]" * 32, "f.yaml")
    assert str(refusal("[" * 33)[0]) == "f.yaml:1:33: nested deeper than 32 levels; allowed: at most 32"
    assert "more than 10 values" in refusal("[" + "1," * 11 + "]", max_nodes=10)[0].message
    assert "more than 50000 values" in refusal("- 1\n" * 50_001)[0].message


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.system", "!mine", "!!str", "!", "!<x>", "!<tag:a,b:c>"]
)
def test_t05_tags(tag: str) -> None:
    assert str(refusal(f"a: {tag} [ls]")[0]).startswith("f.yaml:1:4: the tag ")


def test_t06_duplicate_key_names_both_lines() -> None:
    (finding,) = refusal("speed: 1\nplace: x\nspeed: 2\n")
    assert str(finding) == "f.yaml:3:1: the key 'speed' is here again, first on line 1; allowed: once"


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("1e-3", 0.001),
        ("1E3", 1000.0),
        ("-.5", -0.5),
        ("+7", 7),
        ("0x1F", 31),
        ("0o17", 15),
        ("0", 0),
        ("0.50", 0.5),
        ("true", True),
        ("FALSE", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("1.2.3", "1.2.3"),
        ("512.7 NAG", "512.7 NAG"),
        ("y", "y"),
        ("x_1", "x_1"),
        ("nowhere", "nowhere"),
    ],
)
def test_t07_numbers_and_words(word: str, value: object) -> None:
    read = parse_document(f"a: {word}".encode(), "f.yaml").data["a"]
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    "word",
    [
        "1:30",
        "190:20:30",
        "012",
        "089",
        "-012",
        "NO",
        "no",
        "off",
        "On",
        "YES",
        "2024-01-02",
        "1_000",
        "0b101",
        "2001-12-14t21:59:43.10-05:00",
        "2024-1-2 10:00:00",
        "0o_7",
        "1_0.5",
        "=",
    ],
)
def test_t08_ambiguous_words_need_quotes(word: str) -> None:
    (finding,) = refusal(f"a: 1\nb: {word}")
    assert (finding.line, finding.column) == (2, 4)
    assert "allowed: in quotes if it is text" in finding.message
    assert parse_document(f"b: '{word}'".encode(), "f.yaml").data == {"b": word}


@pytest.mark.parametrize("word", [".nan", ".NaN", ".inf", "-.INF", "+.inf", "1e309", "-1e999", "1" * 5000])
def test_t09_finite_numbers_only(word: str) -> None:
    (finding,) = refusal(f"a: {word}")
    assert (finding.line, finding.column) == (1, 4)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "f.yaml:1:1: the file is empty; allowed: keys with values"),
        (b"# only a comment\n", "f.yaml:1:1: the file is empty; allowed: keys with values"),
        (b"--- \n--- \n", "f.yaml:2:1: a second document begins; allowed: one in a file"),
        (
            b"\xef\xbb\xbfa: 1",
            "f.yaml:1:1: starts with a UTF-8 byte order mark; allowed: plain UTF-8 without one",
        ),
        ("a: 1".encode("utf-16"), "f.yaml:1:1: starts with a UTF-16 byte order mark; allowed: plain"),
        ("a: 1".encode("utf-16-le"), "f.yaml:1:2: the character U+0000 can't be printed"),
        ("ä: 1\nbü: ".encode() + b"\xff", "f.yaml:2:5: the byte 0xff is not UTF-8; allowed: UTF-8"),
        (b"a: \xed\xa0\x80", "f.yaml:1:4: the byte 0xed is not UTF-8"),
        (b'a: "\\ud800"', "f.yaml:1:4: half a character (a lone surrogate)"),
        (b'"\\ud800": 1', "f.yaml:1:1: half a character (a lone surrogate)"),
        (b'a: 1\nb: "\\UFFFFFFFF"', "f.yaml:2:1: an escape or a version that is out of range"),
        (b"%YAML 1.1\n---\na: no", "f.yaml:2:1: YAML 1.1 is asked for; allowed: YAML 1.2"),
        (b"a: 1\nb: " + b"x" * 20_001, "f.yaml:2:1: a line of more than 20000 characters"),
    ],
)
def test_t14_encoding_and_emptiness(content: bytes, said: str) -> None:
    assert str(refusal(content)[0]).startswith(said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a:\n\tb: 1", "f.yaml:2:1: a tab begins this line or word; allowed: spaces"),
        ("a: b: c", "f.yaml:1:5: a ':' where no key can stand"),
        ("a:\n  b: 1\n c: 2", "f.yaml:3:2: the indentation fits none of the lines above"),
        ("a: 1\nb\nc: 3", "f.yaml:2:1: a line without ':'"),
        ("a: [1, 2", "f.yaml:1:9: a bracket is"),
        ("a: 1\nb: 'x", "f.yaml:2:4: quotes are opened and never closed"),
        ("? [a, b]\n: 1", "f.yaml:1:3: a key that isn't a word"),
    ],
)
def test_syntax_in_words_of_people(text: str, said: str) -> None:
    assert str(refusal(text)[0]).startswith(said)


def test_everything_is_told_at_once() -> None:
    findings = refusal("a: NO\nb: &x 1\na: 012\nc: [1\n")
    assert [f.line for f in findings] == [1, 2, 3, 3, 5]


def test_t16_the_bytes_read_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "task.yaml"
    path.write_bytes(b"a: 1\n")
    document = read_document(path)
    path.write_bytes(b"a: 2\n")
    assert document.data == {"a": 1}
    assert document.sha256 == hashlib.sha256(b"a: 1\n").hexdigest()
    assert parse_document(document.content, str(path)).sha256 == document.sha256
    assert isinstance(document, Document)


def test_t18_terminal_escapes_are_shown_escaped() -> None:
    (finding,) = refusal('"\\e[2J\\u202e": 1\n"\\e[2J\\u202e": 2\n')
    assert str(finding).isascii()
    assert str(finding).isprintable()
    assert (
        str(Finding("\x1b]0;x\x07.yaml", 1, 2, "a\nb\r\x9b1mc"))
        == "\\x1b]0;x\\x07.yaml:1:2: a\\x0ab\\x0d\\x9b1mc"
    )


def test_names_are_read_in_composed_form() -> None:
    composed, decomposed = "K\u00fcche", "Ku\u0308che"
    document = parse_document(f"{decomposed}: {decomposed}\nquoted: '{decomposed}'\n".encode(), "f.yaml")
    assert document.data == {composed: composed, "quoted": composed}
    with pytest.raises(FileError, match="first on line 1"):
        parse_document(f"{decomposed}: 1\n{composed}: 2\n".encode(), "f.yaml")
